// TCP sockets of the system: addresses as people write them, listening, connecting, sending without waiting for ever.
#pragma once

#include <sys/socket.h>

#include <atomic>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sheaf {

/// A place in a network.
struct Endpoint {
  std::string host;  ///< a name or an address, IPv6 without brackets
  int port = 0;      ///< 0: any that is free

  /// "host:port", IPv6 addresses in brackets.
  std::string text() const;
};

/// What the value of `option` says: "host:port", "[IPv6 address]:port", or the port alone where there is a
/// `default_host`. Throws Error (exit code 2) for other texts, and for ports below `least_port` or above 65535.
Endpoint parse_endpoint(const std::string& option, const std::string& text, const std::string& default_host,
                        int least_port);

/// An open socket, or none; closed at the end of its life.
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
  /// Gives the socket away: somebody else closes it.
  int release() { return std::exchange(descriptor_, -1); }

 private:
  int descriptor_ = -1;
};

/// An address that a name stands for.
struct Address {
  sockaddr_storage storage;
  socklen_t size;

  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
};

/// All addresses that a name stands for, at least one; for listening there if `to_listen`. May take as long as the
/// network's servers of names do. Throws Error (exit code 1) if there are none.
std::vector<Address> resolve(const Endpoint& endpoint, bool to_listen);

/// A socket that listens. Throws Error (exit code 1): the port is taken, the address is none of this machine's.
Socket listen_at(const Endpoint& endpoint);

/// The port at which a socket listens.
int listening_port(const Socket& socket);

/// Whether a socket listens to this machine alone.
bool listens_to_itself(const Socket& socket);

/// Connects to the first of the addresses that answers within `seconds`. Without one, or when `stop` becomes true: no
/// socket, and `why` says what went wrong.
Socket connect_to(const std::vector<Address>& addresses, double seconds, const std::atomic<bool>& stop,
                  std::string& why);

/// Sends all bytes. Returns whether they are on their way: not if the other side is gone or takes nothing for
/// `seconds`, nor when `stop` becomes true.
bool send_all(const Socket& socket, std::string_view bytes, double seconds, const std::atomic<bool>& stop);

/// Whether the other side has ended the connection.
bool is_hung_up(const Socket& socket);

}  // namespace sheaf
