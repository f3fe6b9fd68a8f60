// The owner rule: the application that last became FOCUSED.
#include <gtest/gtest.h>

#include "service/daemon/clients/owner.h"

namespace omni::daemon {
namespace test_daemon_owner {

using protocol::ClientRole;
using protocol::SessionState;

TEST(Owner, NobodyOwnsWithoutFocus) {
  OwnerTable table;
  EXPECT_TRUE(table.empty());
  table.Add(1, ClientRole::kApplication);
  table.SetSession(1, SessionState::kBegun);
  EXPECT_EQ(table.owner(), 0U);
}

TEST(Owner, LastClientToGainFocusOwns) {
  OwnerTable table;
  table.Add(1, ClientRole::kApplication);
  table.Add(2, ClientRole::kApplication);
  table.SetSession(1, SessionState::kFocused);
  table.SetSession(2, SessionState::kFocused);
  EXPECT_EQ(table.owner(), 2U);
  table.SetSession(1, SessionState::kFocused);  // repeated: it did not *become* focused
  EXPECT_EQ(table.owner(), 2U);
  table.SetSession(1, SessionState::kBegun);
  table.SetSession(1, SessionState::kFocused);
  EXPECT_EQ(table.owner(), 1U);
}

TEST(Owner, FallsBackToPreviousOwnerWhenOwnerLeaves) {
  OwnerTable table;
  table.Add(1, ClientRole::kApplication);
  table.Add(2, ClientRole::kApplication);
  table.SetSession(1, SessionState::kFocused);
  table.SetSession(2, SessionState::kFocused);
  table.Remove(2);
  EXPECT_EQ(table.owner(), 1U);
  table.SetSession(1, SessionState::kNone);
  EXPECT_EQ(table.owner(), 0U);
}

TEST(Owner, MonitorsNeverOwn) {
  OwnerTable table;
  table.Add(1, ClientRole::kMonitor);
  table.SetSession(1, SessionState::kFocused);
  EXPECT_EQ(table.owner(), 0U);
}

TEST(Owner, UnknownClientsAreIgnored) {
  OwnerTable table;
  table.SetSession(7, SessionState::kFocused);
  table.Remove(8);
  EXPECT_EQ(table.owner(), 0U);
  EXPECT_EQ(table.session(7), SessionState::kNone);
}

}  // namespace test_daemon_owner
}  // namespace omni::daemon
