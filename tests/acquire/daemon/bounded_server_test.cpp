// SPDX-License-Identifier: Apache-2.0
// Requests that say one thing of themselves and are another, as bytes on a socket.
#include "acquire/daemon/bounded_server.h"

#include <gmock/gmock.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>

#include "tests/acquire/daemon/daemon_under_test.h"

namespace dermap {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr int kPatience_ms = 20000;      // only so that a failure ends
constexpr std::size_t kMuch = 32 << 20;  // more than any buffer of the system's holds

class RawClient {
 public:
  explicit RawClient(int port) : file_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(file_, reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
  }
  ~RawClient() { ::close(file_); }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  bool Send(const std::string& bytes) const {
    return ::send(file_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
  }
  // How much of `bytes`, over and over, the other side takes before it closes.
  std::size_t SendWithoutEnd(const std::string& bytes) const {
    std::size_t sent = 0;
    while (sent < kMuch && Send(bytes)) sent += bytes.size();
    return sent;
  }
  // Until the other side closes.
  std::string Answers() const {
    std::string answers;
    std::array<char, 65536> block;
    pollfd readable{file_, POLLIN, 0};
    while (::poll(&readable, 1, kPatience_ms) > 0) {
      const ssize_t size = ::recv(file_, block.data(), block.size(), 0);
      if (size <= 0) return answers;
      answers.append(block.data(), static_cast<std::size_t>(size));
    }
    return answers + " and is not closed";
  }

 private:
  int file_;
};

class BoundedServer : public acquire_test::DaemonUnderTest {
 protected:
  std::string Head(const std::string& request, const std::string& more) const {
    return request + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(server_->port()) + "\r\n" + more;
  }
  std::string Ask(const std::string& bytes) const {
    const RawClient client(server_->port());
    EXPECT_TRUE(client.Send(bytes));
    return client.Answers();
  }
};

TEST_F(BoundedServer, ReadsNoLineWithoutEnd) {
  const RawClient client(server_->port());
  ASSERT_TRUE(client.Send(Head("GET /api/state", "X-Long: ")));
  EXPECT_LT(client.SendWithoutEnd(std::string(65536, 'a')), kMuch);
}

TEST_F(BoundedServer, ReadsNoHeadWithoutEnd) {
  std::string lines;
  for (int i = 0; i < 5000; ++i) lines += "X-Line: " + std::to_string(i) + "\r\n";
  const RawClient client(server_->port());
  ASSERT_TRUE(client.Send(Head("GET /api/state", "")));
  EXPECT_LT(client.SendWithoutEnd(lines), kMuch);
}

TEST_F(BoundedServer, ReadsNoBodyInChunksAndNoneThatIsCompressed) {
  const std::string json = "Content-Type: application/json\r\n";
  EXPECT_THAT(Ask(Head("POST /api/steer", json + "Transfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n\r\n")),
              StartsWith("HTTP/1.1 411"));
  EXPECT_THAT(Ask(Head("POST /api/steer", json + "\r\n")), StartsWith("HTTP/1.1 411"));
  EXPECT_THAT(Ask(Head("POST /api/steer", json + "Content-Encoding: gzip\r\nContent-Length: 2\r\n\r\n{}")),
              StartsWith("HTTP/1.1 415"));
}

// Another site's page may send text, and write a whole request of ours into it. The head fills a block of the
// library's buffer, which drops the rest of a block after a request.
TEST_F(BoundedServer, TakesNoBodyForARequest) {
  constexpr std::size_t kBlock = 4096;
  const std::string hidden = Head("GET /api/state", "\r\n");
  const std::string length = "Content-Length: " + std::to_string(hidden.size()) + "\r\n\r\n";
  std::string head =
      Head("POST /api/steer", "Origin: http://evil.example\r\nContent-Type: text/plain\r\nX-Fill: ");
  head += std::string(kBlock - head.size() - 2 - length.size(), 'x') + "\r\n" + length;
  const std::string answers = Ask(head + hidden);
  EXPECT_THAT(answers, StartsWith("HTTP/1.1 403"));
  EXPECT_EQ(answers.find("HTTP/1.1", 1), std::string::npos) << answers;
}

TEST_F(BoundedServer, GivesNoPartsOfAnAnswer) {
  std::string ranges = "bytes=0-";
  for (int i = 0; i < 1000; ++i) ranges += ",0-";
  const std::string answer = Ask(Head("GET /", "Connection: close\r\nRange: " + ranges + "\r\n\r\n"));
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200"));
  EXPECT_LT(answer.size(), 100'000u);
}

TEST_F(BoundedServer, AnswersOneGetAfterTheOtherOnOneConnection) {
  const std::string answers =
      Ask(Head("GET /api/schema", "\r\n") + Head("GET /api/state", "Connection: close\r\n\r\n"));
  EXPECT_THAT(answers, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(answers.substr(1), HasSubstr("HTTP/1.1 200"));
  EXPECT_THAT(answers, HasSubstr("\"state\":\"idle\""));
}

// Bytes that come one by one keep no connection for long.
TEST_F(BoundedServer, WaitsForNoRequestForever) {
  ServerOptions options;
  options.port = 0;
  options.request_time = std::chrono::milliseconds(200);
  HttpServer hasty(*daemon_, options);
  std::thread thread([&] { hasty.Run(); });
  {
    const RawClient client(hasty.port());
    ASSERT_TRUE(client.Send("GET /api/state HTTP/1.1\r\nHost: "));
    const auto start = std::chrono::steady_clock::now();
    while (client.Send("x") && std::chrono::steady_clock::now() - start < std::chrono::seconds(20))
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
  }
  hasty.Stop();
  thread.join();
}

}  // namespace
}  // namespace dermap
