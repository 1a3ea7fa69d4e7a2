// A small web server for pages that a running program serves. Wraps GNU libmicrohttpd.
#pragma once

#include "tools/preview/sockets.h"

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

struct MHD_Daemon;

namespace sheaf {

/// A request, valid during the call that receives it.
struct HttpRequest {
  std::string_view method, path;  ///< "GET", "/image.png"
  std::string_view body;
  std::map<std::string, std::string> query = {};  ///< decoded

  /// A value of the query; empty if it is absent.
  std::string_view value(const std::string& name) const;
};

/// Response to a request.
struct HttpResponse {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";  ///< MIME type of the body
  std::shared_ptr<const std::string> body;         ///< null: one line with the meaning of the status
  int number = -1;                                 ///< of the image, as the header Sheaf-Image; negative: none
};

/// Answers GET requests on its own thread from construction to destruction, and POST requests to one path. Other
/// methods get status 405. The server limits requests, connections, connections per address and idle time, so that
/// clients can neither block the program nor exhaust its memory. A server on a loopback address answers 403 if the Host
/// header does not name this machine. This prevents web pages from reading it through a host name of their own (DNS
/// rebinding).
///
/// POST requests change the program's state, so pages of other origins must not send them: the server requires a Host
/// header that names this machine, at any address; an Origin header, if there is one, of this server; and the type
/// application/json, which browsers do not send to other origins without asking.
class HttpServer {
 public:
  /// Returns the response to a request, e.g. of the path "/" or "/image.png". Called on the server's thread.
  using Answer = std::function<HttpResponse(const HttpRequest& request)>;

  /// The path that accepts POST requests, and the maximum size of their body in bytes.
  struct Posts {
    std::string path = {};
    std::size_t max_bytes = 0;
  };

  /// Throws Error (exit code 1) if it cannot listen on the endpoint.
  HttpServer(const Endpoint& endpoint, Answer answer, Posts posts);
  /// Closes all connections immediately.
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  /// URL for browsers: "http://127.0.0.1:8080/".
  const std::string& url() const { return url_; }

  /// The headers that decide whether a request is answered; null: absent.
  struct Headers {
    const char *host, *origin, *type, *length, *site;
  };
  /// The status by which a request is refused before its body is read; 0: it is answered. Called by libmicrohttpd's
  /// callback, as answer().
  int refusal(std::string_view method, std::string_view path, const Headers& headers) const;
  HttpResponse answer(const HttpRequest& request) const;
  std::size_t max_bytes() const { return posts_.max_bytes; }

 private:
  bool names_this_server(std::string_view host) const;

  Answer answer_;
  Posts posts_;
  std::string host_;  ///< of the endpoint
  std::string url_;
  bool is_loopback_ = false;  ///< listens on a loopback address only
  MHD_Daemon* daemon_ = nullptr;
};

}  // namespace sheaf
