// The owner rule: the application that last became FOCUSED.
#include <gtest/gtest.h>

#include "service/daemon/clients/clients.h"

namespace omni::daemon {
namespace test_daemon_owner {

using protocol::ClientRole;
using protocol::SessionState;

TEST(Owner, NobodyOwnsWithoutFocus) {
  Clients table;
  EXPECT_TRUE(table.all().empty());
  table.Add({.id = 1, .role = ClientRole::kApplication}, nullptr);
  table.SetSession(1, SessionState::kBegun);
  EXPECT_EQ(table.owner_id(), 0U);
}

TEST(Owner, LastClientToGainFocusOwns) {
  Clients table;
  table.Add({.id = 1, .role = ClientRole::kApplication}, nullptr);
  table.Add({.id = 2, .role = ClientRole::kApplication}, nullptr);
  table.SetSession(1, SessionState::kFocused);
  table.SetSession(2, SessionState::kFocused);
  EXPECT_EQ(table.owner_id(), 2U);
  table.SetSession(1, SessionState::kFocused);  // repeated: it did not *become* focused
  EXPECT_EQ(table.owner_id(), 2U);
  table.SetSession(1, SessionState::kBegun);
  table.SetSession(1, SessionState::kFocused);
  EXPECT_EQ(table.owner_id(), 1U);
}

TEST(Owner, FallsBackToPreviousOwnerWhenOwnerLeaves) {
  Clients table;
  table.Add({.id = 1, .role = ClientRole::kApplication}, nullptr);
  table.Add({.id = 2, .role = ClientRole::kApplication}, nullptr);
  table.SetSession(1, SessionState::kFocused);
  table.SetSession(2, SessionState::kFocused);
  table.Remove(2);
  EXPECT_EQ(table.owner_id(), 1U);
  table.SetSession(1, SessionState::kNone);
  EXPECT_EQ(table.owner_id(), 0U);
}

TEST(Owner, MonitorsNeverOwn) {
  Clients table;
  table.Add({.id = 1, .role = ClientRole::kMonitor}, nullptr);
  table.SetSession(1, SessionState::kFocused);
  EXPECT_EQ(table.owner_id(), 0U);
}

TEST(Owner, UnknownClientsAreIgnored) {
  Clients table;
  table.SetSession(7, SessionState::kFocused);
  table.Remove(8);
  EXPECT_EQ(table.owner_id(), 0U);
  EXPECT_EQ(table.Find(7), nullptr);
}

}  // namespace test_daemon_owner
}  // namespace omni::daemon
