// A small web server for pages that a program shows while it works. Wraps GNU libmicrohttpd.
#pragma once

#include "tools/sockets.h"

#include <functional>
#include <memory>
#include <string>
#include <string_view>

struct MHD_Daemon;

namespace sheaf {

/// What a request is answered with.
struct HttpResponse {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";  ///< of the content
  std::shared_ptr<const std::string> body;         ///< null: a line that says what the status means
};

/// Answers GET requests, on one thread of its own, from its construction to its destruction. Other methods are answered
/// with 405. Requests, connections, connections by address and the time that one may keep silent are limited, so that
/// clients can neither hold up the program nor fill its memory. A server that listens to its own machine alone answers
/// with 403 where the name of the host is not that of this machine: pages from elsewhere cannot read it under a name of
/// theirs.
class HttpServer {
 public:
  /// What a path, e.g. "/" or "/picture.png", is answered with. Called by the server's thread.
  using Answer = std::function<HttpResponse(std::string_view path)>;

  /// Throws Error (exit code 1) if it cannot listen there.
  HttpServer(const Endpoint& endpoint, Answer answer);
  /// Ends all connections, whatever state they are in.
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  /// Where it is, for browsers: "http://127.0.0.1:8080/".
  const std::string& url() const { return url_; }

  /// What libmicrohttpd's callback calls. Null `host`: there was none.
  HttpResponse answer(const char* path, std::string_view method, const char* host) const;

 private:
  Answer answer_;
  std::string url_;
  bool own_machine_ = false;  ///< listens to its own machine alone
  MHD_Daemon* daemon_ = nullptr;
};

}  // namespace sheaf
