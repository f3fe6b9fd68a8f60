// Selecting a base, finding the processes that hold it, and the error messages.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "service/device/usb/usb_bus.h"
#include "tests/support/process/temp_folder.h"

namespace omni::device {
namespace test_device_usb_choice {

UsbBase Base(const std::string& serial, const std::string& port) {
  return {.serial = serial, .node = "/dev/bus/usb/001/005", .speed = "480 Mbit/s", .port = port, .problem = ""};
}

void ExpectHas(const std::string& text, std::initializer_list<const char*> parts) {
  for (const char* part : parts) EXPECT_NE(text.find(part), std::string::npos) << part << " not in: " << text;
}

TEST(ChooseUsbBase, PicksTheOnlyBaseOrTheNamedOne) {
  EXPECT_EQ(ChooseUsbBase({Base("A17", "1-1")}, "")->serial, "A17");
  EXPECT_EQ(ChooseUsbBase({Base("A17", "1-1"), Base("B2", "1-2")}, "B2")->port, "1-2");
}

TEST(ChooseUsbBase, ErrorWhenNoBaseIsConnected) {
  ExpectHas(ChooseUsbBase({}, "").error(), {"no Omni base on USB", "connect it"});
  ExpectHas(ChooseUsbBase({}, "A17").error(), {"looked for A17"});
}

TEST(ChooseUsbBase, AmbiguityErrorListsSerialsAndTheOption) {
  ExpectHas(ChooseUsbBase({Base("A17", "1-1"), Base("B2", "1-2")}, "").error(),
            {"2 Omni bases", "A17", "B2", "--device usb:SERIAL"});
}

TEST(ChooseUsbBase, UnknownSerialErrorListsConnectedBases) {
  ExpectHas(ChooseUsbBase({Base("A17", "1-1"), Base("", "1-2.3")}, "C3").error(),
            {"no Omni base with serial C3", "A17", "without a serial at port 1-2.3"});
}

TEST(ChooseUsbBase, RejectsDuplicateSerials) {
  ExpectHas(ChooseUsbBase({Base("A17", "1-1"), Base("A17", "1-2")}, "A17").error(), {"disconnect all but one"});
}

TEST(UsbPermission, HelpNamesUdevRuleAndCommands) {
  ExpectHas(UsbPermissionHelp("/dev/bus/usb/001/005"),
            {"/dev/bus/usb/001/005", "manifests/udev/70-omni.rules", "/etc/udev/rules.d/", "udevadm control --reload",
             "udevadm trigger"});
  EXPECT_TRUE(std::filesystem::exists(OMNI_SOURCE_DIR "/manifests/udev/70-omni.rules"));
}

// A folder like /proc, with processes and their open files.
class Proc {
 public:
  void Add(const std::string& pid, const std::string& name, const std::string& open) const {
    folder_.Write(pid + "/comm", name + "\n");
    std::filesystem::create_directories(folder_.Path(pid + "/fd"));
    std::filesystem::create_symlink(open, folder_.Path(pid + "/fd/7"));
  }
  std::string path() const { return folder_.Path("."); }

 private:
  const test::TempFolder folder_;
};

TEST(HoldersOf, FindsProcessesThatHaveTheNodeOpen) {
  const Proc proc;
  proc.Add("120", "omnid", "/dev/bus/usb/001/005");
  proc.Add("15", "omni", "/dev/bus/usb/001/005");
  proc.Add("16", "other", "/dev/bus/usb/001/006");
  proc.Add(std::to_string(getpid()), "this", "/dev/bus/usb/001/005");
  proc.Add("self", "no process", "/dev/bus/usb/001/005");
  EXPECT_EQ(HoldersText(HoldersOf("/dev/bus/usb/001/005", proc.path())), "omni (pid 15), omnid (pid 120)");
  EXPECT_EQ(HoldersText(HoldersOf("/dev/bus/usb/009/009", proc.path())), "");
  EXPECT_TRUE(HoldersOf("/dev/bus/usb/001/005", "/nonexistent").empty());
}

}  // namespace test_device_usb_choice
}  // namespace omni::device
