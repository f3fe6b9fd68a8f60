#include "tests/hil/board/budget.h"

#include <cstdio>
#include <fstream>
#include <memory>
#include <sstream>

#include "tests/hil/board/qemu_board.h"
#include "tests/hil/board/session.h"
#include "tests/hil/board/tools.h"

namespace omni::hil {
namespace {

using base::Error;
using base::Result;

constexpr int kSteps = 8000;  // 2 s of device time, of them 0.3 s of self-test

// Names of the report that go into the budget.
constexpr const char* kIdleNames[] = {"idle_mean", "idle_most", "idle_telemetry_mean", "idle_telemetry_most"};
constexpr const char* kArmedNames[] = {"armed_mean", "armed_most", "armed_telemetry_mean", "armed_telemetry_most",
                                       "stack_bytes"};

Result<QemuBoard::End> RunSession(Session::Manner manner) {
  QemuBoard::Options options;
  options.count_instructions = true;
  auto board = QemuBoard::Start(options);
  if (!board) return Error{board.error()};
  Session session(manner, 1);
  firmware::LockstepAnswer answer;
  for (int i = 0; i < kSteps; ++i) {
    auto stepped = (*board)->Step(session.Next(answer));
    if (!stepped) return Error{stepped.error()};
    answer = *stepped;
  }
  return (*board)->Exit(0);
}

template <std::size_t count>
std::string TakeOver(const QemuBoard::End& end, const char* const (&names)[count], Budget& budget) {
  for (const char* name : names) {
    const auto found = end.report.find(name);
    if (found == end.report.end()) return std::string("the board's report has no ") + name;
    budget[name] = found->second;
  }
  return {};
}

// text + data of an image, as arm-none-eabi-size sees it.
Result<std::uint32_t> ImageSize_bytes(const std::string& image) {
  const std::string command = "arm-none-eabi-size " + ImagePath(image);
  const std::unique_ptr<FILE, int (*)(FILE*)> output(::popen(command.c_str(), "r"), ::pclose);
  char head[256];
  std::uint32_t text = 0, data = 0;
  if (output == nullptr || std::fgets(head, sizeof head, output.get()) == nullptr ||
      std::fscanf(output.get(), "%u %u", &text, &data) != 2) {
    return Error{command + " gives no sizes"};
  }
  return text + data;
}

}  // namespace

Result<Budget> MeasureBudget() {
  Budget budget;
  const auto size = ImageSize_bytes("mps2_lockstep");
  if (!size) return Error{size.error()};
  budget["image_bytes"] = *size;
  const auto idle = RunSession(Session::Manner::kIdle);
  if (!idle) return Error{idle.error()};
  const auto armed = RunSession(Session::Manner::kPlain);
  if (!armed) return Error{armed.error()};
  std::string missing = TakeOver(*idle, kIdleNames, budget);
  if (missing.empty()) missing = TakeOver(*armed, kArmedNames, budget);
  if (!missing.empty()) return Error{missing};
  return budget;
}

Result<Budget> ReadBudget(const std::string& path) {
  std::ifstream file(path);
  Budget budget;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    std::string name, rest;
    std::uint32_t value = 0;
    if (!(words >> name >> value) || words >> rest) {
      return Error{path + ":" + std::to_string(number) + ": is not a name and a number: " + line};
    }
    budget[name] = value;
  }
  if (budget.empty()) return Error{path + " has no rows"};
  return budget;
}

std::string BudgetPage(const Budget& budget) {
  std::ostringstream page;
  page << "# What the control core costs on a Cortex-M7 (QEMU, mps2-an500). A test refuses more than "
       << kBudgetHeadRoom << " times\n"
       << "# these. Made by: build/release/tests/omni_hil_budget > firmware/board/mps2_an500/budget.txt\n"
       << "# image_bytes: text + data of mps2_lockstep; stack_bytes: deepest use; others: instructions of one control "
          "step,\n"
       << "# frames in and out included. \"telemetry\": steps that send a frame.\n";
  for (const auto& [name, value] : budget) page << name << " " << value << "\n";
  return page.str();
}

}  // namespace omni::hil
