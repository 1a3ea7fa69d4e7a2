// A small web server for pages that a running program serves. Wraps GNU libmicrohttpd.
#pragma once

#include "tools/preview/sockets.h"

#include <functional>
#include <memory>
#include <string>
#include <string_view>

struct MHD_Daemon;

namespace sheaf {

/// Response to a request.
struct HttpResponse {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";  ///< MIME type of the body
  std::shared_ptr<const std::string> body;         ///< null: one line with the meaning of the status
};

/// Answers GET requests on its own thread from construction to destruction. Other methods get status 405. The server
/// limits requests, connections, connections per address and idle time, so that clients can neither block the program
/// nor exhaust its memory. A server on a loopback address answers 403 if the Host header does not name this machine.
/// This prevents web pages from reading it through a host name of their own (DNS rebinding).
class HttpServer {
 public:
  /// Returns the response for a path, e.g. "/" or "/image.png". Called on the server's thread.
  using Answer = std::function<HttpResponse(std::string_view path)>;

  /// Throws Error (exit code 1) if it cannot listen on the endpoint.
  HttpServer(const Endpoint& endpoint, Answer answer);
  /// Closes all connections immediately.
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  /// URL for browsers: "http://127.0.0.1:8080/".
  const std::string& url() const { return url_; }

  /// Called by libmicrohttpd's callback. `host` is null if the request has no Host header.
  HttpResponse answer(const char* path, std::string_view method, const char* host) const;

 private:
  Answer answer_;
  std::string url_;
  bool is_loopback_ = false;  ///< listens on a loopback address only
  MHD_Daemon* daemon_ = nullptr;
};

}  // namespace sheaf
