#include "service/monitor/web/web_server.h"

#include <array>
#include <chrono>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "service/base/clock.h"
#include "service/monitor/web/access.h"

namespace omni::monitor {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using boost::system::error_code;

// Requests that are being read or answered: of more, the oldest ends, so that no one who says nothing keeps a page out.
// A browser opens six at once.
constexpr std::size_t kMaxRequests = 16;
constexpr std::uint32_t kMaxHeaderBytes = 8 << 10;
constexpr auto kRequestTime = std::chrono::seconds(10);  // to send a whole request
constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self' ws:; img-src 'self' data: blob:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

struct PageFile {
  std::string_view target;  // of the request
  std::string_view name;    // in the page's folder
  std::string_view type;
};
constexpr PageFile kPageFiles[] = {
    {"/", "index.html", "text/html; charset=utf-8"},
    {"/page.js", "page.js", "text/javascript; charset=utf-8"},
    {"/page.css", "page.css", "text/css; charset=utf-8"},
    {"/licenses.txt", "licenses.txt", "text/plain; charset=utf-8"},
};

std::string_view View(beast::string_view text) { return {text.data(), text.size()}; }

}  // namespace

struct WebServer::Impl {
  struct Page;
  struct Connection;

  Impl(const WebOptions& its_options, WebHandler& its_handler)
      : options(its_options), code(its_options.code), handler(its_handler) {}

  void Accept();
  bool IsOurs(const tcp::socket& socket) const;
  void MakeRoom();
  http::response<http::string_body> Answer(const http::request<http::empty_body>& request);
  // What is wrong with a request for a WebSocket; nothing: it may be accepted.
  std::optional<http::response<http::string_body>> Refusal(const http::request<http::empty_body>& request) const;
  void AddPage(tcp::socket socket, const http::request<http::empty_body>& request);

  const WebOptions options;
  std::string code;  // until it is used
  WebHandler& handler;
  asio::io_context context{1};
  tcp::acceptor acceptor{context};
  std::deque<std::weak_ptr<Connection>> requests;
  PageId last_page = 0;
  std::map<PageId, std::shared_ptr<Page>> pages;
  std::uint64_t bytes_sent = 0;
};

namespace {

http::response<http::string_body> Response(unsigned version, http::status status, std::string_view type,
                                           std::string body) {
  http::response<http::string_body> response(status, version);
  response.set(http::field::content_type, beast::string_view(type.data(), type.size()));
  response.set(http::field::cache_control, "no-store");
  response.set("Content-Security-Policy", kPolicy);
  response.set("X-Content-Type-Options", "nosniff");
  response.set("X-Frame-Options", "DENY");
  response.set("Referrer-Policy", "no-referrer");
  response.set("Cross-Origin-Opener-Policy", "same-origin");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  response.keep_alive(false);
  response.body() = std::move(body);
  response.prepare_payload();
  return response;
}

http::response<http::string_body> Text(unsigned version, http::status status, std::string body) {
  return Response(version, status, "text/plain; charset=utf-8", std::move(body));
}

}  // namespace

// One page's WebSocket.
struct WebServer::Impl::Page : std::enable_shared_from_this<Page> {
  Page(Impl& its_server, PageId its_id, tcp::socket socket)
      : server(its_server), id(its_id), stream(std::move(socket)) {}

  struct Message {
    std::shared_ptr<const std::string> bytes;
    bool binary;
  };

  void Start(const http::request<http::empty_body>& request) {
    stream.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
    stream.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
      response.set(http::field::sec_websocket_protocol, beast::string_view(kPageProtocol.data(), kPageProtocol.size()));
    }));
    stream.read_message_max(server.options.max_message_bytes);
    stream.auto_fragment(false);
    stream.async_accept(request, [self = shared_from_this()](error_code error) {
      if (error) return self->End();
      self->open = true;
      self->server.handler.OnPage(self->id);
      self->Read();
    });
  }

  void Read() {
    stream.async_read(received, [self = shared_from_this()](error_code error, std::size_t) {
      if (error) return self->End();
      const auto data = self->received.cdata();
      const std::string_view bytes(static_cast<const char*>(data.data()), data.size());
      if (self->stream.got_text()) {
        self->server.handler.OnText(self->id, bytes);
      } else {
        self->server.handler.OnBytes(self->id, bytes);
      }
      self->received.consume(self->received.size());
      self->received.shrink_to_fit();  // a dropped file was large
      self->Read();
    });
  }

  void Push(Message message) {
    if (!open || closing) return;
    waiting_bytes += message.bytes->size();
    if (waiting_bytes > kMaxUnsentBytes) return Close(CloseCode::kTooSlow, "this page reads too slowly; reload it");
    waiting.push_back(std::move(message));
    if (waiting.size() == 1) Write();
  }

  void Write() {
    stream.binary(waiting.front().binary);
    stream.async_write(asio::buffer(*waiting.front().bytes),
                       [self = shared_from_this()](error_code error, std::size_t bytes) {
                         if (error) return self->End();
                         self->server.bytes_sent += bytes;
                         self->waiting_bytes -= bytes;
                         self->waiting.pop_front();
                         if (!self->waiting.empty()) return self->Write();
                         if (self->closing) self->SendClose();
                       });
  }

  // After the message that is being sent; what waits behind it is dropped.
  void Close(CloseCode code, std::string_view why) {
    if (closing) return;
    closing = true;
    reason.code = static_cast<std::uint16_t>(code);
    reason.reason.assign(why.data(), std::min<std::size_t>(why.size(), 120));
    if (!open) return End();
    if (waiting.size() > 1) waiting.erase(waiting.begin() + 1, waiting.end());
    if (waiting.empty()) SendClose();
  }

  void SendClose() {
    stream.async_close(reason, [self = shared_from_this()](error_code) { self->End(); });
  }

  void End() {
    const bool was_open = std::exchange(open, false);
    beast::get_lowest_layer(stream).close();
    if (server.pages.erase(id) > 0 && was_open) server.handler.OnPageGone(id);
  }

  Impl& server;
  const PageId id;
  websocket::stream<beast::tcp_stream> stream;
  beast::flat_buffer received;
  std::deque<Message> waiting;  // the first one is being sent
  std::size_t waiting_bytes = 0;
  bool open = false, closing = false;
  websocket::close_reason reason;
};

// One HTTP request and its answer; or it becomes a page.
struct WebServer::Impl::Connection : std::enable_shared_from_this<Connection> {
  Connection(Impl& its_server, tcp::socket socket) : server(its_server), stream(std::move(socket)) {}

  void Start() {
    parser.header_limit(kMaxHeaderBytes);
    parser.body_limit(0);
    stream.expires_after(kRequestTime);
    http::async_read(stream, buffer, parser, [self = shared_from_this()](error_code error, std::size_t) {
      if (error == http::error::header_limit || error == http::error::body_limit) {
        return self->Reply(Text(11, http::status::bad_request, "the request is too large\n"));
      }
      if (error) return;
      self->Handle();
    });
  }

  void Handle() {
    const http::request<http::empty_body> request = parser.release();
    if (!websocket::is_upgrade(request)) return Reply(server.Answer(request));
    if (auto refusal = server.Refusal(request)) return Reply(std::move(*refusal));
    stream.expires_never();
    server.AddPage(stream.release_socket(), request);
  }

  void Reply(http::response<http::string_body> its_response) {
    response = std::move(its_response);
    stream.expires_after(kRequestTime);
    http::async_write(stream, response, [self = shared_from_this()](error_code, std::size_t) {
      error_code ignored;
      self->stream.socket().shutdown(tcp::socket::shutdown_send, ignored);
    });
  }

  Impl& server;
  beast::tcp_stream stream;
  beast::flat_buffer buffer;
  http::request_parser<http::empty_body> parser;
  http::response<http::string_body> response;
};

bool WebServer::Impl::IsOurs(const tcp::socket& socket) const {
  error_code error;
  const tcp::endpoint peer = socket.remote_endpoint(error);
  if (error) return false;
  const auto user = UserOfLoopback(peer.port(), acceptor.local_endpoint().port());
  return user && (*user == 0 || *user == options.user.value_or(::geteuid()));
}

void WebServer::Impl::MakeRoom() {
  std::erase_if(requests, [](const std::weak_ptr<Connection>& one) { return one.expired(); });
  while (requests.size() >= kMaxRequests) {
    if (const auto oldest = requests.front().lock()) oldest->stream.close();
    requests.pop_front();
  }
}

void WebServer::Impl::Accept() {
  acceptor.async_accept([this](error_code error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (!error && IsOurs(socket)) {
      MakeRoom();
      const auto connection = std::make_shared<Connection>(*this, std::move(socket));
      requests.push_back(connection);
      connection->Start();
    }
    Accept();
  });
}

http::response<http::string_body> WebServer::Impl::Answer(const http::request<http::empty_body>& request) {
  const unsigned version = request.version();
  if (!HostAllowed(View(request[http::field::host]), acceptor.local_endpoint().port())) {
    return Text(version, http::status::forbidden, "this address is not the one that omni printed; open that one\n");
  }
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    return Text(version, http::status::method_not_allowed, "only GET and HEAD are served here\n");
  }
  const bool head = request.method() == http::verb::head;
  std::string_view target = View(request.target());
  target = target.substr(0, target.find('?'));
  if (target == "/hello") {
    const std::string_view origin = View(request[http::field::origin]);
    if (!origin.empty() && !OriginAllowed(origin, acceptor.local_endpoint().port())) {
      return Text(version, http::status::forbidden, "another page may not ask here\n");
    }
    const std::string_view authorization = View(request[http::field::authorization]);
    if (SameToken(OnceCode(authorization), code)) {
      code.clear();
      return Response(version, http::status::ok, "application/json", "{\"token\": \"" + options.token + "\"}");
    }
    if (!SameToken(BearerToken(authorization), options.token)) {
      return Text(version, http::status::forbidden,
                  "the token is missing, or of another start of omni; open the address that it printed\n");
    }
    return Response(version, http::status::ok, "application/json", head ? std::string() : handler.HelloJson());
  }
  for (const PageFile& file : kPageFiles) {
    if (target != file.target) continue;
    std::ifstream in(std::filesystem::path(options.folder) / file.name, std::ios::binary);
    if (!in) break;
    std::ostringstream content;
    content << in.rdbuf();
    return Response(version, http::status::ok, file.type, head ? std::string() : content.str());
  }
  return Text(version, http::status::not_found, "there is no such file\n");
}

std::optional<http::response<http::string_body>> WebServer::Impl::Refusal(
    const http::request<http::empty_body>& request) const {
  const auto refuse = [&](http::status status, std::string text) {
    return Text(request.version(), status, std::move(text));
  };
  const std::uint16_t port = acceptor.local_endpoint().port();
  if (!HostAllowed(View(request[http::field::host]), port)) return refuse(http::status::forbidden, "foreign Host\n");
  const std::string_view origin = View(request[http::field::origin]);
  if (!origin.empty() && !OriginAllowed(origin, port)) return refuse(http::status::forbidden, "foreign Origin\n");
  if (!SameToken(ProtocolToken(View(request[http::field::sec_websocket_protocol])), options.token)) {
    return refuse(http::status::forbidden, "wrong token; open the address that omni printed\n");
  }
  if (View(request.target()) != "/live") return refuse(http::status::not_found, "the WebSocket is /live\n");
  if (pages.size() >= options.max_pages) {
    return refuse(http::status::service_unavailable, "as many pages are open as may be; close one\n");
  }
  return std::nullopt;
}

void WebServer::Impl::AddPage(tcp::socket socket, const http::request<http::empty_body>& request) {
  const PageId id = ++last_page;
  auto page = std::make_shared<Page>(*this, id, std::move(socket));
  pages[id] = page;
  page->Start(request);
}

WebServer::WebServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

WebServer::~WebServer() {
  try {
    for (const auto& [id, page] : std::map(impl_->pages)) page->Close(CloseCode::kEnds, "omni has ended");
    RunUntil(base::MonotonicNow_ns() + 50'000'000);  // what can be sent in that time
    impl_->acceptor.close();
    const auto left = std::exchange(impl_->pages, {});
    for (const auto& [id, page] : left) page->open = false;
  } catch (...) {  // out of memory, or a handler's: the sockets close without a word
  }
}

base::Result<std::unique_ptr<WebServer>> WebServer::Listen(const WebOptions& options, WebHandler& handler) {
  auto impl = std::make_unique<Impl>(options, handler);
  const tcp::endpoint endpoint(asio::ip::address_v4::loopback(), options.port);
  error_code error;
  impl->acceptor.open(endpoint.protocol(), error);
  if (!error) impl->acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) impl->acceptor.bind(endpoint, error);
  if (!error) impl->acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) {
    return base::Error{"port " + std::to_string(options.port) + " of 127.0.0.1: " + error.message() +
                       "; name another with --port, or leave it out for any that is free"};
  }
  impl->Accept();
  return std::unique_ptr<WebServer>(new WebServer(std::move(impl)));
}

std::uint16_t WebServer::port() const { return impl_->acceptor.local_endpoint().port(); }

void WebServer::RunUntil(std::int64_t t_ns) {
  const auto left = std::chrono::nanoseconds(t_ns - base::MonotonicNow_ns());
  impl_->context.restart();
  if (left.count() <= 0) {
    impl_->context.poll();
  } else {
    impl_->context.run_for(left);
  }
}

void WebServer::Send(PageId page, std::shared_ptr<const std::string> message, bool binary) {
  const auto found = impl_->pages.find(page);
  if (found == impl_->pages.end()) return;
  const std::shared_ptr<Impl::Page> held = found->second;  // it may end meanwhile
  held->Push({std::move(message), binary});
}

bool WebServer::IsIdle(PageId page) const {
  const auto found = impl_->pages.find(page);
  return found != impl_->pages.end() && found->second->open && found->second->waiting.empty();
}

void WebServer::Close(PageId page, CloseCode code, std::string_view reason) {
  const auto found = impl_->pages.find(page);
  if (found == impl_->pages.end()) return;
  const std::shared_ptr<Impl::Page> held = found->second;
  held->Close(code, reason);
}

std::uint64_t WebServer::bytes_sent() const { return impl_->bytes_sent; }

}  // namespace omni::monitor
