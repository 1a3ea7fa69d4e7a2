// Loopback connections for tests of network code.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cstdint>
#include <string>
#include <utility>

namespace sheaf {

/// An open socket of a test; receiving times out after 10 s.
class LoopbackSocket {
 public:
  explicit LoopbackSocket(int descriptor) : descriptor_(descriptor) {
    const timeval patience{10, 0};
    setsockopt(descriptor_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }
  LoopbackSocket(LoopbackSocket&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  LoopbackSocket(const LoopbackSocket&) = delete;
  ~LoopbackSocket() {
    if (descriptor_ >= 0) close(descriptor_);
  }

  bool is_open() const { return descriptor_ >= 0; }

  /// Connects to a port. The socket is not open if nobody listens there.
  static LoopbackSocket connect_to(int port) {
    const int descriptor = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const sockaddr_in address = loopback(port);
    if (connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0)
      return LoopbackSocket(descriptor);
    close(descriptor);
    return LoopbackSocket(-1);
  }

  /// Listens on a free port.
  static LoopbackSocket listen() {
    const int descriptor = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const sockaddr_in address = loopback(0);
    if (bind(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
        ::listen(descriptor, 4) != 0) {
      close(descriptor);
      return LoopbackSocket(-1);
    }
    return LoopbackSocket(descriptor);
  }

  int port() const {
    sockaddr_in address{};
    socklen_t size = sizeof address;
    getsockname(descriptor_, reinterpret_cast<sockaddr*>(&address), &size);
    return ntohs(address.sin_port);
  }

  LoopbackSocket accept() const { return LoopbackSocket(::accept4(descriptor_, nullptr, nullptr, SOCK_CLOEXEC)); }

  bool send(const std::string& bytes) const {
    std::size_t sent = 0;
    while (sent < bytes.size()) {
      const ssize_t more = ::send(descriptor_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
      if (more <= 0) return false;
      sent += static_cast<std::size_t>(more);
    }
    return true;
  }

  /// All bytes until the peer closes the connection or the timeout passes.
  std::string receive() const {
    std::string bytes;
    char piece[65536];
    for (ssize_t got = 0; (got = recv(descriptor_, piece, sizeof piece, 0)) > 0;)
      bytes.append(piece, static_cast<std::size_t>(got));
    return bytes;
  }

 private:
  static sockaddr_in loopback(int port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    return address;
  }

  int descriptor_;
};

}  // namespace sheaf
