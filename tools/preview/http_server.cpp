#include "tools/preview/http_server.h"

#include "core/io/error.h"

#include <microhttpd.h>
#include <sys/resource.h>
#include <unistd.h>

#include <charconv>
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
     "default-src 'none'; connect-src 'self'; img-src 'self' data: blob:; style-src 'unsafe-inline'; "
     "script-src 'unsafe-inline'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
};

const char* meaning(int status) {
  switch (status) {
    case 204:
      return "";
    case 400:
      return "400 Bad Request\n";
    case 403:
      return "403 Forbidden\n";
    case 404:
      return "404 Not Found\n";
    case 405:
      return "405 Method Not Allowed\n";
    case 409:
      return "409 Conflict\n";
    case 411:
      return "411 Length Required\n";
    case 413:
      return "413 Content Too Large\n";
    case 415:
      return "415 Unsupported Media Type\n";
    default:
      return "500 Internal Server Error\n";
  }
}

/// A Host header without its port. IPv6 addresses are in brackets.
std::string_view without_port(std::string_view host) { return host.substr(0, host.find(':')); }

/// Whether a Host header names this machine: as localhost or by an IP address, which web pages from elsewhere cannot
/// use.
bool names_this_machine(std::string_view host) {
  if (host.starts_with("[")) return true;
  host = without_port(host);
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
  if (response.number >= 0) complete = add("Sheaf-Image", std::to_string(response.number).c_str()) && complete;
  if (response.status == 405) complete = add("Allow", "GET") && complete;
  // The server does not read the rest of a request that it refuses
  if (response.status >= 400) complete = add("Connection", "close") && complete;
  const auto status = static_cast<unsigned>(response.status);
  const MHD_Result queued = complete ? MHD_queue_response(connection, status, made) : MHD_NO;
  MHD_destroy_response(made);
  return queued;
}

MHD_Result add_argument(void* request, MHD_ValueKind, const char* name, const char* value) {
  constexpr std::size_t kMaxArguments = 16;
  auto& query = static_cast<HttpRequest*>(request)->query;
  if (query.size() >= kMaxArguments) return MHD_NO;
  query[name] = value != nullptr ? value : "";
  return MHD_YES;
}

/// Called when the headers have arrived, again for each part of the body, and at its end. `state`: the body so far;
/// null in the first call.
MHD_Result respond(const HttpServer& server, MHD_Connection* connection, HttpRequest request, const char* part,
                   std::size_t& part_bytes, void*& state) {
  const auto header = [&](const char* name) { return MHD_lookup_connection_value(connection, MHD_HEADER_KIND, name); };
  auto* body = static_cast<std::string*>(state);
  if (body == nullptr) {
    const int refusal = server.refusal(
        request.method, request.path,
        {header("Host"), header("Origin"), header("Content-Type"), header("Content-Length"), header("Sec-Fetch-Site")});
    if (refusal != 0) return send_response(connection, {refusal, HttpResponse().type, nullptr});
    if (request.method != "GET") {
      state = new std::string;  // release_upload() deletes it
      return MHD_YES;
    }
  } else if (part_bytes > 0) {
    if (body->size() + part_bytes > server.max_bytes()) return MHD_NO;
    body->append(part, part_bytes);
    part_bytes = 0;
    return MHD_YES;
  } else {
    request.body = *body;
  }
  MHD_get_connection_values(connection, MHD_GET_ARGUMENT_KIND, add_argument, &request);
  return send_response(connection, server.answer(request));
}

MHD_Result on_request(void* server, MHD_Connection* connection, const char* url, const char* method, const char*,
                      const char* part, std::size_t* part_bytes, void** state) noexcept {
  thread_local const bool is_low [[maybe_unused]] = lower_priority();
  try {
    return respond(*static_cast<const HttpServer*>(server), connection, {method, url, {}}, part, *part_bytes, *state);
  } catch (const std::exception&) {  // out of memory
    return MHD_NO;
  }
}

void release_upload(void*, MHD_Connection*, void** state, MHD_RequestTerminationCode) {
  delete static_cast<std::string*>(*state);
  *state = nullptr;
}

/// The name of this machine in its network.
std::string host_name() {
  char name[256] = "";
  return gethostname(name, sizeof name - 1) == 0 ? name : "";
}

}  // namespace

std::string_view HttpRequest::value(const std::string& name) const {
  const auto found = query.find(name);
  return found != query.end() ? std::string_view(found->second) : std::string_view();
}

HttpServer::HttpServer(const Endpoint& endpoint, Answer answer, Posts posts)
    : answer_(std::move(answer)), posts_(std::move(posts)), host_(endpoint.host) {
  Socket socket = listen_at(endpoint);
  is_loopback_ = listens_on_loopback(socket);
  url_ = fmt::format("http://{}/", Endpoint{endpoint.host, listening_port(socket)}.text());
  daemon_ = MHD_start_daemon(MHD_USE_AUTO | MHD_USE_INTERNAL_POLLING_THREAD, 0, nullptr, nullptr, on_request, this,
                             MHD_OPTION_LISTEN_SOCKET, socket.descriptor(), MHD_OPTION_CONNECTION_LIMIT,
                             kMaxConnections, MHD_OPTION_PER_IP_CONNECTION_LIMIT, kMaxConnectionsByAddress,
                             MHD_OPTION_CONNECTION_TIMEOUT, kMaxIdleSeconds, MHD_OPTION_CONNECTION_MEMORY_LIMIT,
                             kRequestBytes, MHD_OPTION_NOTIFY_COMPLETED, release_upload, nullptr, MHD_OPTION_END);
  if (daemon_ == nullptr) throw Error(ExitCode::kRuntime, "cannot start a web server at " + endpoint.text());
  socket.release();
}

HttpServer::~HttpServer() { MHD_stop_daemon(daemon_); }

bool HttpServer::names_this_server(std::string_view host) const {
  if (names_this_machine(host)) return true;
  const std::string_view name = without_port(host);
  const std::string own = host_name();
  return !name.empty() && (name == host_ || name == own || name == own.substr(0, own.find('.')));
}

int HttpServer::refusal(std::string_view method, std::string_view path, const Headers& headers) const {
  if (is_loopback_ && headers.host != nullptr && !names_this_machine(headers.host)) return 403;
  if (method == "GET") return 0;
  if (method != "POST" || posts_.path.empty() || path != posts_.path) return 405;
  // Only this server's own page may change anything
  if (headers.host == nullptr || !names_this_server(headers.host)) return 403;
  if (headers.origin != nullptr && headers.origin != "http://" + std::string(headers.host)) return 403;
  if (headers.site != nullptr && std::string_view(headers.site) != "same-origin") return 403;
  if (headers.type == nullptr || std::string_view(headers.type) != "application/json") return 415;
  // The size must be known before the body is read
  if (headers.length == nullptr) return 411;
  const std::string_view length = headers.length;
  std::size_t bytes = 0;
  const auto [end, error] = std::from_chars(length.data(), length.data() + length.size(), bytes);
  if (end != length.data() + length.size()) return 400;
  return error == std::errc() && bytes <= posts_.max_bytes ? 0 : 413;
}

HttpResponse HttpServer::answer(const HttpRequest& request) const {
  try {
    return answer_(request);
  } catch (const std::exception&) { return {500, HttpResponse().type, nullptr}; }
}

}  // namespace sheaf
