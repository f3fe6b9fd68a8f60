#include "service/haptics/deformable/soft_contact.h"

#include <cmath>
#include <cstddef>

namespace omni::haptics {
namespace {

constexpr int kSoftNewtonSteps = 12;
constexpr double kForceTolerance = 1e-7;  // relative
constexpr double kMovedWeight = 1e-3;     // a row of the matrix is kept until its place moved by this
constexpr double kStaleDiagonal = 0.05;   // ... or its own compliance changed by this share
constexpr double kLeastGive = 0.1;        // of a patch, of a half-space's

std::size_t Z(int i) { return static_cast<std::size_t>(i); }

// All that is known of a contact before its force.
struct Touch {
  BallCompliance give;
  double depth_m = 0;
  double relaxing_gain = 0;  // share of a new elastic force that is added to it
  double least_m_N = 0;      // compliance of the patch that the columns stand for
  GivePoint now;             // at the force of this iteration
};

double Blend(const SoftBodyView& body, const SoftPlace& place, float SoftNode::*field) noexcept {
  const SoftTriangle& t = body.GetTriangle(place.triangle);
  return place.weights[0] * static_cast<double>(body.Node(t.node[0]).*field) +
         place.weights[1] * static_cast<double>(body.Node(t.node[1]).*field) +
         place.weights[2] * static_cast<double>(body.Node(t.node[2]).*field);
}

// sum over the corners of both places of w_a w_b C_ab
double Between(const SoftBodyView& body, const SoftPlace& a, const SoftPlace& b) noexcept {
  const SoftTriangle& ta = body.GetTriangle(a.triangle);
  const SoftTriangle& tb = body.GetTriangle(b.triangle);
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      sum += a.weights[i] * b.weights[j] * static_cast<double>(body.Compliance(ta.node[i], tb.node[j]));
    }
  }
  return sum;
}

bool SamePlace(const SoftPlace& a, const SoftPlace& b) noexcept {
  return a.triangle == b.triangle && std::abs(a.weights[0] - b.weights[0]) < kMovedWeight &&
         std::abs(a.weights[1] - b.weights[1]) < kMovedWeight;
}

bool Usable(const SoftContact& c) noexcept {
  return c.touching && c.depth_m > 0 && c.depth_m < 1e3 && IsWithin(c.point_base_m, 1e3) && IsWithin(c.normal, 1.001) &&
         c.series_compliance_m_N >= 0 && c.series_compliance_m_N < 1e6;
}

// Compliance that the body adds at a place. Near an edge it grows like one over the distance, so that the whole
// compliance of a patch is blended by its reciprocal; elsewhere both are the same.   (4.5)
double ComplianceAt(const SoftBodyView& body, const SoftPlace& place, double modulus_Pa) noexcept {
  const double flat = 0.6 / (modulus_Pa * body.header().patch_radius_m);
  const SoftTriangle& t = body.GetTriangle(place.triangle);
  double stiffness = 0;
  for (int k = 0; k < 3; ++k) {
    const double give = flat + static_cast<double>(body.Node(t.node[k]).compliance_m_N);
    stiffness += place.weights[k] / std::max(give, kLeastGive * flat);
  }
  return 1 / stiffness - flat;
}

BallCompliance GiveOf(const SoftBodyView& body, const SoftPlace& place, double ball_radius_m,
                      double series_m_N) noexcept {
  const SoftHeader& h = body.header();
  const LocalModel model{std::max(Blend(body, place, &SoftNode::modulus_Pa), 1.0),
                         ContactRadius(ball_radius_m, Blend(body, place, &SoftNode::curvature_1_m)),
                         GainOf(h.poisson_ratio, h.hardening)};
  return MakeBallCompliance(model, ComplianceAt(body, place, model.modulus_Pa), series_m_N);
}

class SoftSystem {
 public:
  SoftSystem(const SoftBodyView& body, SoftContactState& state) noexcept : body_(body), state_(state) {}

  // Takes contact k into the system at its slot.
  void Enter(int k, const SoftContact& contact, double ball_radius_m, double keep) noexcept {
    const double radius_m = ball_radius_m;
    SoftSlot& slot = state_.slots[Z(k)];
    const std::uint32_t hint = slot.active ? slot.place.triangle : kNoSoftTriangle;
    const SoftPlace place = LocateOnSoftBody(body_, contact.point_base_m, hint);
    Touch& touch = touches_[Z(k)];
    touch.relaxing_gain = keep * body_.header().relaxing_share;
    // The spring in series carries the relaxing part too: d = h(f) + c_s ((1 + g) f + rest), rest from before.   (7.2)
    const double rest_N = keep * (slot.relaxing_N - body_.header().relaxing_share * slot.elastic_N);
    touch.give = GiveOf(body_, place, radius_m, contact.series_compliance_m_N * (1 + touch.relaxing_gain));
    touch.depth_m = std::min(contact.depth_m, kDeepest_balls * radius_m) - contact.series_compliance_m_N * rest_N;
    moved_[Z(k)] = !slot.active || !SamePlace(place, slot.place);
    if (moved_[Z(k)]) slot.place = place;
    slot.point_base_m = contact.point_base_m;
    slot.normal = contact.normal;
    slot.model = touch.give.model;
    slot.active = true;
    in_[Z(count_++)] = k;
  }

  const Touch& Of(int k) const noexcept { return touches_[Z(k)]; }

  // Elastic forces into the slots, d force / d depth into `slopes`.
  void Solve(ContactVector& slopes) noexcept {
    if (count_ == 1) {
      SolveAlone(slopes);
    } else if (count_ > 1) {
      SolveTogether(slopes);
    }
  }

 private:
  void SolveAlone(ContactVector& slopes) noexcept {
    const int k = in_[0];
    Touch& touch = touches_[Z(k)];
    SoftSlot& slot = state_.slots[Z(k)];
    slot.elastic_N = ForceAlone(touch.give, touch.depth_m, slot.dent_m);
    touch.now = GiveAtForce(touch.give, slot.elastic_N, slot.dent_m);
    slopes[Z(k)] = slot.elastic_N > 0 ? 1 / touch.now.slope_m_N : 0;
    state_.factor.count = 0;
    state_.matrix[Z(k)][Z(k)] = 0;  // its row is recomputed when another ball joins
  }

  // Modified Newton: A = C between the balls + their own slopes, f >= 0   (6.3).
  void SolveTogether(ContactVector& slopes) noexcept {
    ContactVector force{};
    for (int i = 0; i < count_; ++i) {
      const int k = in_[Z(i)];
      const SoftSlot& slot = state_.slots[Z(k)];
      Touch& touch = touches_[Z(k)];
      touch.least_m_N = 1.001 * Between(body_, slot.place, slot.place);
      force[Z(k)] = slot.elastic_N > 0 ? slot.elastic_N : ForceAlone(touch.give, touch.depth_m, 0);
      touch.now = GiveAtForce(touch.give, force[Z(k)], slot.dent_m);
    }
    RefreshRows();
    for (int step = 0; step < kSoftNewtonSteps; ++step) {
      if (Iterate(force) <= kForceTolerance) break;
      RefreshDiagonal();
    }
    InverseDiagonal(state_.factor, slopes);
    for (int i = 0; i < count_; ++i) state_.slots[Z(in_[Z(i)])].elastic_N = force[Z(in_[Z(i)])];
  }

  // One step of it; the largest change of a force over the largest force.
  double Iterate(ContactVector& force) noexcept {
    ContactVector right{};
    for (int i = 0; i < count_; ++i) {
      const int k = in_[Z(i)];
      const Touch& touch = touches_[Z(k)];
      right[Z(k)] = touch.depth_m - touch.now.depth_m + state_.matrix[Z(k)][Z(k)] * force[Z(k)];
    }
    ContactVector next = force;
    SolveContact(state_.matrix, kMaxSoftContacts, right, state_.factor, next);
    double change = 0;
    double largest = 1e-300;
    for (int i = 0; i < count_; ++i) {
      const int k = in_[Z(i)];
      Touch& touch = touches_[Z(k)];
      change = std::max(change, std::abs(next[Z(k)] - force[Z(k)]));
      largest = std::max(largest, next[Z(k)]);
      touch.now = GiveAtForce(touch.give, next[Z(k)], touch.now.dent_m);
    }
    force = next;
    return change / largest;
  }

  // Own slope, at least the compliance of the patch the columns stand for, so that A stays positive definite.
  double Diagonal(int k) const noexcept { return std::max(touches_[Z(k)].now.slope_m_N, touches_[Z(k)].least_m_N); }

  bool Positioned(int k, int& position) const noexcept {
    for (position = 0; position < state_.factor.count; ++position) {
      if (state_.factor.node[Z(position)] == k) return true;
    }
    return false;
  }

  // Rows whose place moved, and all if nothing was kept; the factor is updated one by one, or recomputed when most have
  // changed.
  void RefreshRows() noexcept {
    int changed = 0;
    std::array<bool, kMaxSoftContacts> stale{};
    for (int i = 0; i < count_; ++i) {
      const int k = in_[Z(i)];
      const double diagonal = state_.matrix[Z(k)][Z(k)];
      stale[Z(k)] = moved_[Z(k)] || !(diagonal > 0) || IsStale(diagonal, Diagonal(k));
      if (!stale[Z(k)]) continue;
      ++changed;
      for (int j = 0; j < count_; ++j) {
        const int m = in_[Z(j)];
        if (m == k) continue;
        const double c = Between(body_, state_.slots[Z(k)].place, state_.slots[Z(m)].place);
        state_.matrix[Z(k)][Z(m)] = state_.matrix[Z(m)][Z(k)] = c;
      }
      state_.matrix[Z(k)][Z(k)] = Diagonal(k);
    }
    Refactor(stale, changed);
  }

  static bool IsStale(double kept, double now) noexcept { return std::abs(kept - now) > kStaleDiagonal * now; }

  void RefreshDiagonal() noexcept {
    int changed = 0;
    std::array<bool, kMaxSoftContacts> stale{};
    for (int i = 0; i < count_; ++i) {
      const int k = in_[Z(i)];
      const double now = Diagonal(k);
      if (!IsStale(state_.matrix[Z(k)][Z(k)], now)) continue;
      state_.matrix[Z(k)][Z(k)] = now;
      stale[Z(k)] = true;
      ++changed;
    }
    Refactor(stale, changed);
  }

  void Refactor(const std::array<bool, kMaxSoftContacts>& stale, int changed) noexcept {
    if (changed == 0) return;
    ActiveFactor& factor = state_.factor;
    if (3 * changed > factor.count) {
      const ActiveFactor before = factor;
      factor.count = 0;
      for (int p = 0; p < before.count; ++p) AddNode(state_.matrix, before.node[Z(p)], factor);
      return;
    }
    for (int k = 0; k < kMaxSoftContacts; ++k) {
      int position = 0;
      if (!stale[Z(k)] || !Positioned(k, position)) continue;
      RemoveNode(position, factor);
      AddNode(state_.matrix, k, factor);
    }
  }

  const SoftBodyView& body_;
  SoftContactState& state_;
  std::array<Touch, kMaxSoftContacts> touches_{};
  std::array<int, kMaxSoftContacts> in_{};
  std::array<bool, kMaxSoftContacts> moved_{};
  int count_ = 0;
};

void Leave(int k, SoftContactState& state) noexcept {
  SoftSlot& slot = state.slots[Z(k)];
  if (!slot.active) return;
  for (int position = 0; position < state.factor.count; ++position) {
    if (state.factor.node[Z(position)] != k) continue;
    RemoveNode(position, state.factor);
    break;
  }
  slot = {};
  for (ContactVector& row : state.matrix) row[Z(k)] = 0;
  state.matrix[Z(k)] = {};
}

}  // namespace

void StepSoftContacts(const SoftBodyView& body, std::span<const SoftContact> contacts, double ball_radius_m,
                      double dt_s, SoftContactState& state, std::span<SoftForce> forces) noexcept {
  const SoftHeader& h = body.header();
  const bool sound = ball_radius_m > 1e-6 && ball_radius_m < 1 && contacts.size() == forces.size();
  const double dt = dt_s >= 0 ? std::min(dt_s, 0.1) : 0;
  const double keep = h.relaxation_time_s > 0 ? std::exp(-dt / h.relaxation_time_s) : 0;
  SoftSystem system(body, state);
  for (SoftForce& force : forces) force = {};
  ContactVector last_N{};
  for (int k = 0; k < kMaxSoftContacts; ++k) {
    last_N[Z(k)] = state.slots[Z(k)].elastic_N;
    const bool touched = sound && Z(k) < contacts.size() && Usable(contacts[Z(k)]);
    if (touched) {
      system.Enter(k, contacts[Z(k)], ball_radius_m, keep);
    } else {
      Leave(k, state);
    }
  }
  ContactVector slopes{};
  system.Solve(slopes);
  for (std::size_t k = 0; k < forces.size() && k < Z(kMaxSoftContacts); ++k) {
    SoftSlot& slot = state.slots[k];
    if (!slot.active) continue;
    const Touch& touch = system.Of(static_cast<int>(k));
    const double gain = touch.relaxing_gain;
    slot.dent_m = touch.now.dent_m;
    slot.carried_m = touch.give.compliance_m_N * slot.elastic_N;
    // r' = g f' - r / tau over a tick; the force is f + r   (7.1)
    slot.relaxing_N = keep * slot.relaxing_N + gain * (slot.elastic_N - last_N[k]);
    const double force_N = slot.elastic_N > 0 ? std::max(0.0, slot.elastic_N + slot.relaxing_N) : 0;
    forces[k] = {force_N, slot.elastic_N, slot.dent_m, force_N > 0 ? (1 + gain) * slopes[k] : 0};
  }
}

}  // namespace omni::haptics
