// TCP sockets: parsing of addresses, listening, connecting, and sending with a timeout.
#pragma once

#include <sys/socket.h>

#include <atomic>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sheaf {

/// A host and port.
struct Endpoint {
  std::string host;  ///< a name or an address, IPv6 without brackets
  int port = 0;      ///< 0: any free port

  /// "host:port", with IPv6 addresses in brackets.
  std::string text() const;
};

/// Parses the value of `option`: "host:port", "[IPv6 address]:port", or only the port if `default_host` is not empty.
/// Throws Error (exit code 2) for malformed text, and for ports below `min_port` or above 65535.
Endpoint parse_endpoint(const std::string& option, const std::string& text, const std::string& default_host,
                        int min_port);

/// Owner of a socket, possibly empty. The destructor closes it.
class Socket {
 public:
  Socket() = default;
  explicit Socket(int descriptor) : descriptor_(descriptor) {}
  Socket(Socket&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  Socket& operator=(Socket&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~Socket();

  bool is_open() const { return descriptor_ >= 0; }
  int descriptor() const { return descriptor_; }
  /// Releases ownership; the caller must close the socket.
  int release() { return std::exchange(descriptor_, -1); }

 private:
  int descriptor_ = -1;
};

/// A resolved address.
struct Address {
  sockaddr_storage storage;
  socklen_t size;

  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
};

/// All addresses of an endpoint, at least one; for listening if `to_listen`. May block for name servers. Throws Error
/// (exit code 1) if there are none.
std::vector<Address> resolve(const Endpoint& endpoint, bool to_listen);

/// Opens a listening socket. Throws Error (exit code 1), for example if the port is in use or the address is not local.
Socket listen_at(const Endpoint& endpoint);

/// Port of a listening socket.
int listening_port(const Socket& socket);

/// Whether a socket listens on a loopback address only.
bool listens_on_loopback(const Socket& socket);

/// Connects to the first address that answers, waiting up to `seconds` for each. Returns an empty socket on failure or
/// when `stop` becomes true; `why` receives the error.
Socket connect_to(const std::vector<Address>& addresses, double seconds, const std::atomic<bool>& stop,
                  std::string& why);

/// Sends all bytes. Returns false if the peer is gone, if it accepts nothing for `seconds`, or when `stop` becomes
/// true.
bool send_all(const Socket& socket, std::string_view bytes, double seconds, const std::atomic<bool>& stop);

/// Whether the peer has closed the connection.
bool is_hung_up(const Socket& socket);

}  // namespace sheaf
