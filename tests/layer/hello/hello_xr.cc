// Khronos' hello_xr as Debian packages it, unmodified, over the test runtime: what it draws is looked at, with and
// without the layer.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <stb/stb_image.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <thread>
#include <vector>

#include "tests/layer/support/fake_service.h"
#include "tests/support/process/temp_folder.h"

namespace omni::test {
namespace test_hello_xr {

constexpr const char* kLayer = "XR_APILAYER_OMNI_stylus";
constexpr const char* kOpengl = "OpenGL";
constexpr int kEyeSide = 1024;
// A driver in software that crashes is no fault of ours; it is tried again, and counted.
constexpr int kAttempts = 3;

struct Picture {
  std::vector<std::uint32_t> pixels;  // rows from the top

  explicit Picture(const std::string& file) {
    int width = 0;
    int height = 0;
    int channels = 0;
    const std::unique_ptr<stbi_uc, void (*)(void*)> bytes(stbi_load(file.c_str(), &width, &height, &channels, 3),
                                                          stbi_image_free);
    if (bytes == nullptr || width != kEyeSide || height != kEyeSide) return;
    for (int i = 0; i < width * height; ++i) {
      const stbi_uc* const rgb = bytes.get() + 3 * i;
      pixels.push_back(static_cast<std::uint32_t>(rgb[0] << 16 | rgb[1] << 8 | rgb[2]));
    }
  }

  std::map<std::uint32_t, int> Colors() const {
    std::map<std::uint32_t, int> counts;
    for (const std::uint32_t pixel : pixels) ++counts[pixel];
    return counts;
  }
  // The colour of most pixels.
  std::uint32_t Background() const {
    const auto counts = Colors();
    return std::max_element(counts.begin(), counts.end(),
                            [](const auto& a, const auto& b) { return a.second < b.second; })
        ->first;
  }
  // Part of the pixels that are of another colour, in the square around a place.
  double Covered(int x, int y, int half_side) const {
    int covered = 0;
    int all = 0;
    const std::uint32_t background = Background();
    for (int row = std::max(0, y - half_side); row < std::min(kEyeSide, y + half_side); ++row) {
      for (int column = std::max(0, x - half_side); column < std::min(kEyeSide, x + half_side); ++column, ++all)
        if (pixels[static_cast<std::size_t>(row * kEyeSide + column)] != background) ++covered;
    }
    return static_cast<double>(covered) / all;
  }
};

// An X server without a screen, on a display number that is free.
class XServer {
 public:
#ifdef OMNI_XVFB
  XServer() {
    int number[2] = {-1, -1};
    if (pipe(number) != 0) return;
    child_ = fork();
    if (child_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      const int nowhere = open("/dev/null", O_WRONLY);
      dup2(nowhere, STDERR_FILENO);
      close(number[0]);
      const std::string file = std::to_string(number[1]);
      execl(OMNI_XVFB, OMNI_XVFB, "-displayfd", file.c_str(), "-screen", "0", "640x480x24", "-nolisten", "tcp",
            nullptr);
      _exit(127);
    }
    close(number[1]);
    // It writes the number and a line feed when it is ready.
    for (char next = 0; read(number[0], &next, 1) == 1 && next != '\n';) display_ += next;
    close(number[0]);
  }
  ~XServer() {
    if (child_ <= 0) return;
    kill(child_, SIGTERM);
    waitpid(child_, nullptr, 0);
  }
#endif
  std::string display() const { return ":" + display_; }

 private:
  pid_t child_ = -1;
  std::string display_;
};

std::string ReadAll(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

// Until its eleventh frame with layers; then the end of its standard input, at which it ends by itself.
class HelloRun {
 public:
  HelloRun(const std::string& graphics, const std::string& layers, const std::function<void()>& meanwhile) {
    std::optional<XServer> x_server;
    if (graphics == kOpengl) setenv("DISPLAY", x_server.emplace().display().c_str(), 1);
    for (int i = 0; i < kAttempts; ++i) {
      std::filesystem::remove(folder_.Path("crash"));
      status_ = Once(graphics, layers, meanwhile);
      if (!WIFSIGNALED(status_) || !IsDriver(ReadAll(folder_.Path("crash")))) break;
      ++driver_crashes_;
    }
    std::printf("hello_xr -g %s: the driver crashed %d times\n", graphics.c_str(), driver_crashes_);
  }

  bool ended_well() const { return WIFEXITED(status_) && WEXITSTATUS(status_) == 0; }
  std::string Report() const {
    return "status " + std::to_string(status_) + ", crash in " + ReadAll(folder_.Path("crash")) + "\n" +
           ReadAll(folder_.Path("log"));
  }
  std::string Frame() const { return ReadAll(folder_.Path("frame.txt")); }
  Picture Eye(const std::string& eye) const { return Picture(folder_.Path(eye + ".png")); }

 private:
  static bool IsDriver(const std::string& culprit) {
    return culprit.find("libvulkan_lvp") != std::string::npos || culprit == "generated code\n";
  }

  int Once(const std::string& graphics, const std::string& layers, const std::function<void()>& meanwhile) {
    std::filesystem::remove(folder_.Path("frame.txt"));
    int input[2] = {-1, -1};
    if (pipe2(input, O_CLOEXEC) != 0) return -1;
    const pid_t child = fork();
    if (child == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      const int log = open(folder_.Path("log").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
      dup2(input[0], STDIN_FILENO);
      dup2(log, STDOUT_FILENO);
      dup2(log, STDERR_FILENO);
      setenv("XR_ENABLE_API_LAYERS", layers.c_str(), 1);
      setenv("OMNI_TEST_RUNTIME_PICTURES", folder_.Path().c_str(), 1);
      setenv("OMNI_TEST_RUNTIME_CRASH", folder_.Path("crash").c_str(), 1);
      if (graphics == kOpengl) setenv("LD_PRELOAD", OMNI_MODE_LINES, 1);
      execl(OMNI_HELLO_XR, OMNI_HELLO_XR, "-g", graphics.c_str(), nullptr);
      _exit(127);
    }
    close(input[0]);
    int status = -1;
    while (child > 0 && waitpid(child, &status, WNOHANG) == 0) {
      meanwhile();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      if (input[1] >= 0 && Frame().rfind("frame 11 ", 0) == 0) {
        close(input[1]);
        input[1] = -1;
      }
    }
    if (input[1] >= 0) close(input[1]);
    return status;
  }

  TempFolder folder_;
  int status_ = -1;
  int driver_crashes_ = 0;
};

const char* const kGraphics[] = {
    "Vulkan2",
    "Vulkan",
#ifdef OMNI_XVFB
    kOpengl,
#endif
};

class HelloXr : public testing::TestWithParam<const char*> {};

void ExpectScene(const Picture& picture) {
  ASSERT_EQ(picture.pixels.size(), std::size_t{kEyeSide} * kEyeSide);
  const auto colors = picture.Colors();
  EXPECT_GE(colors.size(), 4u) << "background and three faces of a cube at least";
  EXPECT_GT(colors.at(picture.Background()), kEyeSide * kEyeSide / 3);
}

// The pen's tip rests 60 mm above the base: 0.45 m in front of the eyes and 0.29 m below them, where hello_xr draws
// nothing unless a hand is there.
TEST_P(HelloXr, DrawsItsSceneAndWithTheLayerAHandWhereThePenIs) {
  constexpr int kColumn = kEyeSide / 2;
  constexpr int kRow = kEyeSide / 2 + static_cast<int>(0.5 * kEyeSide * 0.29 / 0.45);
  constexpr int kAround = 60;  // half of a cube of 0.1 m at that distance
  const HelloRun without(GetParam(), "", [] {});
  ASSERT_TRUE(without.ended_well()) << without.Report();
  EXPECT_EQ(without.Frame(), "frame 11 layers 1\n");
  EXPECT_NE(without.Eye("left").pixels, without.Eye("right").pixels) << "the eyes are apart";
  FakeService service;
  const HelloRun with(GetParam(), kLayer, [&] { service.Fill(); });
  ASSERT_TRUE(with.ended_well()) << with.Report();
  EXPECT_EQ(service.heard().applications, std::vector<std::string>{"HelloXR"});
  for (const char* eye : {"left", "right"}) {
    const Picture seen = with.Eye(eye);
    const Picture before = without.Eye(eye);
    ExpectScene(seen);
    ExpectScene(before);
    EXPECT_LT(before.Covered(kColumn, kRow, kAround), 0.05) << eye;
    EXPECT_GT(seen.Covered(kColumn, kRow, kAround), 0.5) << eye;
  }
}

INSTANTIATE_TEST_SUITE_P(Graphics, HelloXr, testing::ValuesIn(kGraphics),
                         [](const auto& instance) { return std::string(instance.param); });

}  // namespace test_hello_xr
}  // namespace omni::test
