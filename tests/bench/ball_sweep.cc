// An hour of sliding: balls of 0.5 to 3 mm through haptics::Step over boxes, sharp parts, thin, concave and organic
// bodies. Prints one row per body; exit status 1 if a centre was ever inside, or a force ever pulled the tip inwards.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iterator>

#include "tests/support/touch/ball_bodies.h"
#include "tests/support/touch/ball_judge.h"

namespace omni::haptics {
namespace {

constexpr double kRadii_m[] = {0.0005, 0.00075, 0.001, 0.0015, 0.002, 0.003};
constexpr double kTurns_rad[] = {0, 0.7};
constexpr std::uint64_t kRuns = std::size(kRadii_m) * std::size(kTurns_rad);  // of each body

struct Options {
  std::uint64_t seed = 1;
  double minutes = 60;
};

void PrintRow(const char* name, std::size_t triangles, const BallVerdict& v) {
  std::printf("%-16s %6zu %9llu %9llu %9llu %8llu %8llu %6llu %8llu %10.1e\n", name, triangles,
              static_cast<unsigned long long>(v.ticks), static_cast<unsigned long long>(v.touching),
              static_cast<unsigned long long>(v.judged), static_cast<unsigned long long>(v.inside),
              static_cast<unsigned long long>(v.inverted), static_cast<unsigned long long>(v.falls),
              static_cast<unsigned long long>(v.longest_inside), v.least_gap);
  std::fflush(stdout);
}

BallVerdict SweepBody(const InputObject& object, std::uint64_t ticks_a_run, Random& seeds) {
  BallVerdict sum;
  for (const double turn_rad : kTurns_rad) {
    const InputObject turned = Turned(object, {1, 2, 3}, turn_rad);
    for (const double radius_m : kRadii_m) sum.Add(SlideOver(turned, radius_m, ticks_a_run, seeds.Next()));
  }
  return sum;
}

int Run(const Options& options) {
  const std::vector<BallBody> bodies = BallBodies();
  const double ticks_a_run = std::ceil(options.minutes * 60e3 / static_cast<double>(bodies.size() * kRuns));
  Random seeds(options.seed);
  BallVerdict sum;
  std::printf("seed %llu\n%-16s %6s %9s %9s %9s %8s %8s %6s %8s %10s\n", static_cast<unsigned long long>(options.seed),
              "body", "tris", "ticks", "touching", "judged", "inside", "inverted", "falls", "longest", "least gap");
  for (const BallBody& body : bodies) {
    const BallVerdict verdict = SweepBody(body.object, static_cast<std::uint64_t>(ticks_a_run), seeds);
    PrintRow(body.name.c_str(), body.object.triangles.size(), verdict);
    sum.Add(verdict);
  }
  PrintRow("all", 0, sum);
  return sum.inside + sum.inverted > 0 ? 1 : 0;
}

}  // namespace
}  // namespace omni::haptics

int main(int argc, char** argv) {
  omni::haptics::Options options;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--seed") == 0 && i + 1 < argc) {
      options.seed = std::strtoull(argv[++i], nullptr, 10);
    } else if (std::strcmp(argv[i], "--minutes") == 0 && i + 1 < argc) {
      options.minutes = std::strtod(argv[++i], nullptr);
    } else {
      std::fprintf(stderr, "usage: %s [--seed N] [--minutes M]\n", argv[0]);
      return 2;
    }
  }
  return omni::haptics::Run(options);
}
