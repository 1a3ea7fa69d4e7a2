#include "tools/preview/http_server.h"

#include "core/io/error.h"

#include <microhttpd.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstring>

namespace sheaf {

namespace {

constexpr unsigned kMaxConnections = 64, kMaxConnectionsByAddress = 32;
constexpr unsigned kMaxIdleSeconds = 10;          // s
constexpr std::size_t kRequestBytes = 16 * 1024;  // per connection: a request with all its headers

/// Headers of every response. The page is a single file that needs no other resources, so browsers may fetch nothing
/// else.
constexpr std::pair<const char*, const char*> kHeaders[] = {
    {"Cache-Control", "no-store"},
    {"X-Content-Type-Options", "nosniff"},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Content-Security-Policy",
     "default-src 'none'; connect-src 'self'; img-src 'self' data:; style-src 'unsafe-inline'; "
     "script-src 'unsafe-inline'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
};

const char* meaning(int status) {
  switch (status) {
    case 403:
      return "403 Forbidden\n";
    case 404:
      return "404 Not Found\n";
    case 405:
      return "405 Method Not Allowed\n";
    default:
      return "500 Internal Server Error\n";
  }
}

/// Whether a Host header names this machine: as localhost or by an IP address, which web pages from elsewhere cannot
/// use.
bool names_this_machine(std::string_view host) {
  if (host.starts_with("[")) return true;
  host = host.substr(0, host.find(':'));
  if (host == "localhost") return true;
  return !host.empty() && host.find_first_not_of("0123456789.") == std::string_view::npos;
}

/// Gives the calling thread a lower priority than the render.
bool lower_priority() {
  constexpr int kNice = 5;
  return setpriority(PRIO_PROCESS, 0, kNice) == 0;  // on Linux, this affects the thread only
}

void release_body(void* body) { delete static_cast<std::shared_ptr<const std::string>*>(body); }

MHD_Result send_response(MHD_Connection* connection, HttpResponse response) {
  if (!response.body) response.body = std::make_shared<const std::string>(meaning(response.status));
  const std::string& bytes = *response.body;
  auto owner = std::make_unique<std::shared_ptr<const std::string>>(response.body);
  MHD_Response* made = MHD_create_response_from_buffer_with_free_callback_cls(
      bytes.size(), const_cast<char*>(bytes.data()), release_body, owner.get());
  if (made == nullptr) return MHD_NO;
  static_cast<void>(owner.release());  // release_body() deletes it
  const auto add = [made](const char* name, const char* value) {
    return MHD_add_response_header(made, name, value) == MHD_YES;
  };
  bool complete = add("Content-Type", response.type.c_str());
  for (const auto& [name, value] : kHeaders) complete = add(name, value) && complete;
  // The server does not read the rest of such a request
  if (response.status == 405) complete = add("Allow", "GET") && add("Connection", "close") && complete;
  const auto status = static_cast<unsigned>(response.status);
  const MHD_Result queued = complete ? MHD_queue_response(connection, status, made) : MHD_NO;
  MHD_destroy_response(made);
  return queued;
}

MHD_Result on_request(void* server, MHD_Connection* connection, const char* url, const char* method, const char*,
                      const char*, std::size_t*, void**) noexcept {
  thread_local const bool is_low [[maybe_unused]] = lower_priority();
  try {
    const char* const host = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "Host");
    return send_response(connection, static_cast<const HttpServer*>(server)->answer(url, method, host));
  } catch (const std::exception&) {  // out of memory
    return MHD_NO;
  }
}

}  // namespace

HttpServer::HttpServer(const Endpoint& endpoint, Answer answer) : answer_(std::move(answer)) {
  Socket socket = listen_at(endpoint);
  is_loopback_ = listens_on_loopback(socket);
  url_ = fmt::format("http://{}/", Endpoint{endpoint.host, listening_port(socket)}.text());
  daemon_ =
      MHD_start_daemon(MHD_USE_AUTO | MHD_USE_INTERNAL_POLLING_THREAD, 0, nullptr, nullptr, on_request, this,
                       MHD_OPTION_LISTEN_SOCKET, socket.descriptor(), MHD_OPTION_CONNECTION_LIMIT, kMaxConnections,
                       MHD_OPTION_PER_IP_CONNECTION_LIMIT, kMaxConnectionsByAddress, MHD_OPTION_CONNECTION_TIMEOUT,
                       kMaxIdleSeconds, MHD_OPTION_CONNECTION_MEMORY_LIMIT, kRequestBytes, MHD_OPTION_END);
  if (daemon_ == nullptr) throw Error(ExitCode::kRuntime, "cannot start a web server at " + endpoint.text());
  socket.release();
}

HttpServer::~HttpServer() { MHD_stop_daemon(daemon_); }

HttpResponse HttpServer::answer(const char* path, std::string_view method, const char* host) const {
  HttpResponse response;
  if (is_loopback_ && host != nullptr && !names_this_machine(host)) {
    response.status = 403;
  } else if (method != "GET") {
    response.status = 405;
  } else {
    try {
      response = answer_(path);
    } catch (const std::exception&) { response = {500, response.type, nullptr}; }
  }
  return response;
}

}  // namespace sheaf
