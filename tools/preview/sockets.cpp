#include "tools/preview/sockets.h"

#include "core/io/error.h"
#include "scene/xml/xml.h"
#include "tools/console/progress.h"

#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>

namespace sheaf {

namespace {

/// Interval at which waiting functions check whether to stop, ms.
constexpr int kPollInterval = 50;

std::string system_message(int number) { return std::strerror(number); }

/// Waits until the socket is writable. Returns false after `seconds`, or when `stop` becomes true.
bool wait_until_writable(int descriptor, double seconds, const std::atomic<bool>& stop) {
  const double end = Progress::steady_seconds() + seconds;
  while (!stop && Progress::steady_seconds() < end) {
    pollfd waited{descriptor, POLLOUT, 0};
    if (poll(&waited, 1, kPollInterval) > 0) return true;
  }
  return false;
}

Socket open_socket(const Address& address, bool blocking) {
  return Socket(socket(address.storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC | (blocking ? 0 : SOCK_NONBLOCK), 0));
}

sockaddr_storage local_address(const Socket& socket) {
  sockaddr_storage storage{};
  socklen_t size = sizeof storage;
  getsockname(socket.descriptor(), reinterpret_cast<sockaddr*>(&storage), &size);
  return storage;
}

}  // namespace

std::string Endpoint::text() const {
  const bool is_ipv6 = host.find(':') != std::string::npos;
  return fmt::format("{}:{}", is_ipv6 ? fmt::format("[{}]", host) : host, port);
}

Endpoint parse_endpoint(const std::string& option, const std::string& text, const std::string& default_host,
                        int min_port) {
  const auto wrong = [&] {
    const std::string form = default_host.empty() ? "HOST:PORT" : "PORT or ADDRESS:PORT";
    return Error(ExitCode::kUsage,
                 fmt::format("{} {}: expected {}, the port from {} to 65535, IPv6 addresses in brackets", option,
                             in_quotes(text), form, min_port));
  };
  Endpoint endpoint{default_host, 0};
  std::string_view port = text;
  if (const std::size_t colon = text.rfind(':'); colon != std::string::npos) {
    endpoint.host = text.substr(0, colon);
    port.remove_prefix(colon + 1);
    const bool in_brackets = endpoint.host.starts_with("[") && endpoint.host.ends_with("]");
    if (in_brackets) endpoint.host = endpoint.host.substr(1, endpoint.host.size() - 2);
    if (in_brackets != (endpoint.host.find(':') != std::string::npos)) throw wrong();
  }
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), endpoint.port);
  const bool is_number = error == std::errc() && end == port.data() + port.size();
  if (endpoint.host.empty() || !is_number || endpoint.port < min_port || endpoint.port > 65535) throw wrong();
  return endpoint;
}

Socket::~Socket() {
  if (is_open()) close(descriptor_);
}

std::vector<Address> resolve(const Endpoint& endpoint, bool to_listen) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV | (to_listen ? AI_PASSIVE : 0);
  addrinfo* found = nullptr;
  const int failure = getaddrinfo(endpoint.host.c_str(), std::to_string(endpoint.port).c_str(), &hints, &found);
  if (failure != 0)
    throw Error(ExitCode::kRuntime,
                fmt::format("cannot find the host {}: {}", in_quotes(endpoint.host), gai_strerror(failure)));
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(found, freeaddrinfo);
  std::vector<Address> addresses;
  for (const addrinfo* each = found; each != nullptr; each = each->ai_next) {
    Address address{};
    if (each->ai_addrlen > sizeof address.storage) continue;
    std::memcpy(&address.storage, each->ai_addr, each->ai_addrlen);
    address.size = each->ai_addrlen;
    addresses.push_back(address);
  }
  return addresses;
}

Socket listen_at(const Endpoint& endpoint) {
  constexpr int kBacklog = 16;  // backlog of connections
  int number = 0;
  for (const Address& address : resolve(endpoint, true)) {
    Socket socket = open_socket(address, false);
    const int on = 1;  // reuse the port while old connections of a terminated program are closing
    if (socket.is_open()) setsockopt(socket.descriptor(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (socket.is_open() && bind(socket.descriptor(), address.get(), address.size) == 0 &&
        listen(socket.descriptor(), kBacklog) == 0)
      return socket;
    number = errno;
  }
  throw Error(ExitCode::kRuntime, fmt::format("cannot listen at {}: {}", endpoint.text(), system_message(number)));
}

int listening_port(const Socket& socket) {
  const sockaddr_storage storage = local_address(socket);
  return storage.ss_family == AF_INET6 ? ntohs(reinterpret_cast<const sockaddr_in6&>(storage).sin6_port)
                                       : ntohs(reinterpret_cast<const sockaddr_in&>(storage).sin_port);
}

bool listens_on_loopback(const Socket& socket) {
  const sockaddr_storage storage = local_address(socket);
  if (storage.ss_family == AF_INET6) {
    const in6_addr& address = reinterpret_cast<const sockaddr_in6&>(storage).sin6_addr;
    return std::memcmp(&address, &in6addr_loopback, sizeof address) == 0;
  }
  return ntohl(reinterpret_cast<const sockaddr_in&>(storage).sin_addr.s_addr) >> 24 == 127;
}

Socket connect_to(const std::vector<Address>& addresses, double seconds, const std::atomic<bool>& stop,
                  std::string& why) {
  for (const Address& address : addresses) {
    Socket socket = open_socket(address, false);
    int failure = socket.is_open() ? 0 : errno;
    if (failure == 0 && connect(socket.descriptor(), address.get(), address.size) != 0) failure = errno;
    if (failure == EINPROGRESS) {
      socklen_t size = sizeof failure;
      if (!wait_until_writable(socket.descriptor(), seconds, stop))
        failure = ETIMEDOUT;
      else
        getsockopt(socket.descriptor(), SOL_SOCKET, SO_ERROR, &failure, &size);
    }
    if (failure == 0) return socket;
    why = system_message(failure);
  }
  return Socket();
}

bool send_all(const Socket& socket, std::string_view bytes, double seconds, const std::atomic<bool>& stop) {
  while (!bytes.empty()) {
    const ssize_t sent = send(socket.descriptor(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    } else if (sent < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
      if (!wait_until_writable(socket.descriptor(), seconds, stop)) return false;
    } else if (sent == 0 || errno != EINTR) {
      return false;
    }
    if (stop) return false;
  }
  return true;
}

bool is_hung_up(const Socket& socket) {
  pollfd looked{socket.descriptor(), POLLRDHUP, 0};
  return poll(&looked, 1, 0) > 0 && (looked.revents & (POLLRDHUP | POLLHUP | POLLERR)) != 0;
}

}  // namespace sheaf
