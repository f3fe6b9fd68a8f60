#include "tests/probe/options.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <sstream>

#include "service/base/files/nearest_word.h"
#include "tests/probe/bindings.h"

namespace probe {

const char* const kUsage =
    "usage: omni_probe [options]\n"
    "  --name NAME       application name that the runtime sees (default omni_probe)\n"
    "  --profiles LIST   interaction profiles to suggest bindings for: mx_ink,touch,simple (default: all)\n"
    "  --hand HAND       right (default) or left\n"
    "  --seconds S       how long to run (default 10)\n"
    "  --hz RATE         how often to sync and locate (default 90)\n"
    "  --json FILE       write what was seen\n"
    "  --samples         with --json: the path of the pose too\n"
    "  --no-haptics      no pulse when select is pressed\n"
    "  --expect-pen      fail unless a profile, a valid pose and a select press were seen\n"
    "  --quiet           print errors only\n";

namespace {

constexpr const char* kFlags[] = {"--name", "--profiles", "--hand",       "--seconds", "--hz",
                                  "--json", "--samples",  "--no-haptics", "--quiet",   "--expect-pen"};

bool ParseNumber(const char* text, double low, double high, double* value) {
  char* end = nullptr;
  *value = std::strtod(text, &end);
  return end != text && *end == '\0' && *value >= low && *value <= high;
}

std::string ParseProfiles(const std::string& list, std::vector<std::string>* profiles) {
  profiles->clear();
  std::istringstream stream(list);
  for (std::string name; std::getline(stream, name, ',');) {
    if (FindProfile(name) != nullptr) {
      profiles->push_back(name);
      continue;
    }
    return "--profiles: '" + name + "' is none of mx_ink, touch, simple" +
           omni::base::DidYouMean(name, Options().profiles);
  }
  return profiles->empty() ? "--profiles: names none" : "";
}

bool ParseFlag(const std::string& flag, Options* options) {
  if (flag == "--no-haptics") {
    options->haptics = false;
  } else if (flag == "--quiet") {
    options->quiet = true;
  } else if (flag == "--samples") {
    options->samples = true;
  } else if (flag == "--expect-pen") {
    options->expect_pen = true;
  } else if (flag == "--plant-error") {
    options->plant_error = true;
  } else {
    return false;
  }
  return true;
}

std::string ParseValue(const std::string& flag, const char* value, Options* options) {
  if (flag == "--name") {
    // XrApplicationInfo has room for 127 bytes.
    const size_t length = std::strlen(value);
    if (!(length >= 1 && length <= 127)) return "--name: must have 1 to 127 bytes";
    options->name = value;
  } else if (flag == "--profiles") {
    return ParseProfiles(value, &options->profiles);
  } else if (flag == "--hand") {
    options->hand = value;
    if (options->hand != "right" && options->hand != "left") return "--hand: must be right or left";
  } else if (flag == "--seconds") {
    if (!ParseNumber(value, 0.0, 1e6, &options->seconds)) return "--seconds: must be a number from 0 to 1000000";
  } else if (flag == "--hz") {
    if (!ParseNumber(value, 1.0, 2000.0, &options->rate_Hz)) return "--hz: must be a number from 1 to 2000";
  } else if (flag == "--json") {
    options->json = value;
  } else {
    return "there is no option '" + flag + "'" + omni::base::DidYouMean(flag, kFlags);
  }
  return "";
}

}  // namespace

std::string Parse(int argc, char** argv, Options* options) {
  for (int i = 1; i < argc; ++i) {
    const std::string flag = argv[i];
    if (ParseFlag(flag, options)) continue;
    const bool known = std::find(std::begin(kFlags), std::end(kFlags), flag) != std::end(kFlags);
    if (known && i + 1 == argc) return flag + ": its value is missing";
    std::string error = ParseValue(flag, known ? argv[++i] : "", options);
    if (!error.empty()) return error;
  }
  return "";
}

}  // namespace probe
