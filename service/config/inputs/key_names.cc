#include "service/config/inputs/input_table.h"

#include <linux/input-event-codes.h>

#include <charconv>
#include <iterator>

// Keyboards, pedals, buttons of mice and game pads; any other key is written as its number.
// clang-format off
#define OMNI_KEYS(X) \
    X(KEY_ESC) X(KEY_1) X(KEY_2) X(KEY_3) X(KEY_4) X(KEY_5) X(KEY_6) X(KEY_7) X(KEY_8) X(KEY_9) X(KEY_0)               \
    X(KEY_MINUS) X(KEY_EQUAL) X(KEY_BACKSPACE) X(KEY_TAB) X(KEY_Q) X(KEY_W) X(KEY_E) X(KEY_R) X(KEY_T) X(KEY_Y)        \
    X(KEY_U) X(KEY_I) X(KEY_O) X(KEY_P) X(KEY_LEFTBRACE) X(KEY_RIGHTBRACE) X(KEY_ENTER) X(KEY_LEFTCTRL) X(KEY_A)       \
    X(KEY_S) X(KEY_D) X(KEY_F) X(KEY_G) X(KEY_H) X(KEY_J) X(KEY_K) X(KEY_L) X(KEY_SEMICOLON) X(KEY_APOSTROPHE)         \
    X(KEY_GRAVE) X(KEY_LEFTSHIFT) X(KEY_BACKSLASH) X(KEY_Z) X(KEY_X) X(KEY_C) X(KEY_V) X(KEY_B) X(KEY_N) X(KEY_M)      \
    X(KEY_COMMA) X(KEY_DOT) X(KEY_SLASH) X(KEY_RIGHTSHIFT) X(KEY_KPASTERISK) X(KEY_LEFTALT) X(KEY_SPACE)               \
    X(KEY_CAPSLOCK) X(KEY_F1) X(KEY_F2) X(KEY_F3) X(KEY_F4) X(KEY_F5) X(KEY_F6) X(KEY_F7) X(KEY_F8) X(KEY_F9)          \
    X(KEY_F10) X(KEY_NUMLOCK) X(KEY_SCROLLLOCK) X(KEY_KP7) X(KEY_KP8) X(KEY_KP9) X(KEY_KPMINUS) X(KEY_KP4)             \
    X(KEY_KP5) X(KEY_KP6) X(KEY_KPPLUS) X(KEY_KP1) X(KEY_KP2) X(KEY_KP3) X(KEY_KP0) X(KEY_KPDOT) X(KEY_102ND)          \
    X(KEY_F11) X(KEY_F12) X(KEY_KPENTER) X(KEY_RIGHTCTRL) X(KEY_KPSLASH) X(KEY_SYSRQ) X(KEY_RIGHTALT) X(KEY_HOME)      \
    X(KEY_UP) X(KEY_PAGEUP) X(KEY_LEFT) X(KEY_RIGHT) X(KEY_END) X(KEY_DOWN) X(KEY_PAGEDOWN) X(KEY_INSERT)              \
    X(KEY_DELETE) X(KEY_MUTE) X(KEY_VOLUMEDOWN) X(KEY_VOLUMEUP) X(KEY_KPEQUAL) X(KEY_PAUSE) X(KEY_KPCOMMA)             \
    X(KEY_LEFTMETA) X(KEY_RIGHTMETA) X(KEY_COMPOSE) X(KEY_UNDO) X(KEY_MENU) X(KEY_PROG1) X(KEY_PROG2) X(KEY_PROG3)     \
    X(KEY_PROG4) X(KEY_BACK) X(KEY_FORWARD) X(KEY_NEXTSONG) X(KEY_PLAYPAUSE) X(KEY_HOMEPAGE) X(KEY_REDO) X(KEY_F13)    \
    X(KEY_F14) X(KEY_F15) X(KEY_F16) X(KEY_F17) X(KEY_F18) X(KEY_F19) X(KEY_F20) X(KEY_F21) X(KEY_F22) X(KEY_F23)      \
    X(KEY_F24) X(KEY_PRINT) X(BTN_0) X(BTN_1) X(BTN_2) X(BTN_3) X(BTN_4) X(BTN_5) X(BTN_6) X(BTN_7) X(BTN_8)           \
    X(BTN_9) X(BTN_LEFT) X(BTN_RIGHT) X(BTN_MIDDLE) X(BTN_SIDE) X(BTN_EXTRA) X(BTN_FORWARD) X(BTN_BACK) X(BTN_TASK)    \
    X(BTN_TRIGGER) X(BTN_THUMB) X(BTN_THUMB2) X(BTN_TOP) X(BTN_TOP2) X(BTN_PINKIE) X(BTN_BASE) X(BTN_BASE2)            \
    X(BTN_BASE3) X(BTN_BASE4) X(BTN_BASE5) X(BTN_BASE6) X(BTN_DEAD) X(BTN_SOUTH) X(BTN_EAST) X(BTN_C) X(BTN_NORTH)     \
    X(BTN_WEST) X(BTN_Z) X(BTN_TL) X(BTN_TR) X(BTN_TL2) X(BTN_TR2) X(BTN_SELECT) X(BTN_START) X(BTN_MODE)              \
    X(BTN_THUMBL) X(BTN_THUMBR)
// clang-format on

namespace omni::config {
namespace {

struct KeyName {
  std::string_view name;
  std::uint16_t code;
};

#define OMNI_KEY_ROW(key) {#key, key},
constexpr KeyName kKeys[] = {OMNI_KEYS(OMNI_KEY_ROW)};
#undef OMNI_KEY_ROW

static_assert(kHighestKey == KEY_MAX);

}  // namespace

std::optional<std::uint16_t> KeyCode(std::string_view name) {
  for (const KeyName& key : kKeys) {
    if (key.name == name) return key.code;
  }
  unsigned code = 0;
  const char* end = name.data() + name.size();
  const auto [at, error] = std::from_chars(name.data(), end, code);
  if (error != std::errc{} || at != end || !(code >= 1 && code <= kHighestKey)) return std::nullopt;
  return static_cast<std::uint16_t>(code);
}

std::string KeyNameOf(std::uint16_t code) {
  for (const KeyName& key : kKeys) {
    if (key.code == code) return std::string(key.name);
  }
  return std::to_string(code);
}

}  // namespace omni::config
