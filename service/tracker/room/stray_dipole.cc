#include "service/tracker/room/stray_dipole.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "service/magnetics/dipole.h"
#include "service/tracker/kernel/matrices.h"
#include "service/tracker/solve/spiral.h"

namespace omni::tracker {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
constexpr int kN = static_cast<int>(kDipoleParameters);
using Vector6 = Eigen::Matrix<double, kN, 1>;
using Matrix6 = Eigen::Matrix<double, kN, kN>;
using RowVector = Matrix<kReadings, 1>;

constexpr int kDirections = 40;
constexpr std::array<double, 3> kDistances_m{0.2, 0.3, 0.45};
constexpr int kPlaces = kDirections * static_cast<int>(kDistances_m.size());
constexpr double kDampingStart = 1e-3, kDampingMin = 1e-6, kDampingMax = 1e3;
constexpr double kInnovationMax = 20;      // of one scan, in the mean
constexpr double kInnovationMemory = 0.3;  // share of the newest
constexpr double kMisfitMemory = 0.02;
constexpr double kDof = static_cast<double>(kReadings - StrayScan::kEliminated);

Vector6 ToVector(const DipoleNumbers& p) noexcept { return AsVector(p); }
void Put(const Vector6& from, DipoleNumbers& to) noexcept { AsVector(to) = from; }
auto Information(const StrayEvidence& e) noexcept { return AsMatrix<kReadings>(e.information_1_T2); }
auto Gradient(const StrayEvidence& e) noexcept { return AsVector(e.gradient_1_T); }
Eigen::Map<Matrix6> Covariance(StrayDipole& dipole) noexcept { return Eigen::Map<Matrix6>(dipole.covariance.data()); }

Matrix3d GainOf(const Model& model, std::size_t sensor) noexcept {
  Matrix3d gain;
  for (std::size_t e = 0; e < 9; ++e) {
    gain(static_cast<int>(e / 3), static_cast<int>(e % 3)) = model.gain_sensor_base[e][sensor];
  }
  return gain;
}

// x(p), and J = dx/dp.
struct Field {
  RowVector x_T;
  Eigen::Matrix<double, kReadings, kN> J;
};

Field FieldAt(const Model& model, const Vector6& p) noexcept {
  using Columns = Eigen::Matrix<double, 3, 1 + kN>;
  const Vector3d at_m = p.head<3>(), moment_Am2 = p.tail<3>();
  const auto& sensors = model.places[0].position_base_m;
  std::array<Columns, kSensors> of;
  Columns mean = Columns::Zero();
  for (std::size_t i = 0; i < kSensors; ++i) {
    const Vector3d d = Vector3d(sensors[0][i], sensors[1][i], sensors[2][i]) - at_m;
    of[i].col(0) = magnetics::DipoleField(moment_Am2, d);
    of[i].block<3, 3>(0, 1) = -magnetics::DipoleGradient(moment_Am2, d);
    of[i].block<3, 3>(0, 4) = magnetics::DipoleMatrix(d);
    mean += of[i] / kSensors;
  }
  Field field;
  for (std::size_t i = 0; i < kSensors; ++i) {
    const Columns reading = GainOf(model, i) * (of[i] - mean);
    for (int axis = 0; axis < 3; ++axis) {
      const int row = static_cast<int>(kSensors) * axis + static_cast<int>(i);
      field.x_T[row] = reading(axis, 0);
      field.J.row(row) = reading.block<1, kN>(axis, 1);
    }
  }
  return field;
}

bool IsPlace(const DipoleOptions& options, const Vector6& p) noexcept {
  const double distance_m = p.head<3>().norm();
  return p.allFinite() && distance_m >= options.near_m && distance_m <= options.far_m;
}

Vector6 PriorInformation(const DipoleOptions& options) noexcept {
  Vector6 information;
  information << Vector3d::Constant(1 / (options.position_m * options.position_m)),
      Vector3d::Constant(1 / (options.moment_Am2 * options.moment_Am2));
  return information;
}

// Of the misfit, and the prior's.
double Saved(const DipoleOptions& options, const StrayEvidence& said, const RowVector& x_T, const Vector6& p) noexcept {
  return 2 * Gradient(said).dot(x_T) - x_T.dot(Information(said) * x_T) -
         p.dot(PriorInformation(options).cwiseProduct(p));
}

// J^T I J + prior
Matrix6 InformationAt(const DipoleOptions& options, const StrayEvidence& said, const Field& field) noexcept {
  Matrix6 H = field.J.transpose() * (Information(said) * field.J);
  H.diagonal() += PriorInformation(options);
  return H;
}

Vector3d PlaceOf(int place) noexcept {
  return kDistances_m[static_cast<std::size_t>(place / kDirections)] * OnSpiral(place % kDirections, kDirections);
}

// dx/dm, whatever the moment.
Eigen::Matrix<double, kReadings, 3> MomentColumns(const Model& model, const Vector3d& at_m) noexcept {
  const auto& sensors = model.places[0].position_base_m;
  std::array<Matrix3d, kSensors> of;
  Matrix3d mean = Matrix3d::Zero();
  for (std::size_t i = 0; i < kSensors; ++i) {
    of[i] = magnetics::DipoleMatrix(Vector3d(sensors[0][i], sensors[1][i], sensors[2][i]) - at_m);
    mean += of[i] / kSensors;
  }
  Eigen::Matrix<double, kReadings, 3> columns;
  for (std::size_t i = 0; i < kSensors; ++i) {
    const Matrix3d reading = GainOf(model, i) * (of[i] - mean);
    for (int axis = 0; axis < 3; ++axis) {
      columns.row(static_cast<int>(kSensors) * axis + static_cast<int>(i)) = reading.row(axis);
    }
  }
  return columns;
}

// The moment that a dipole there would have, linear in the evidence.
void ScorePlace(const DipoleOptions& options, const Model& model, const StrayEvidence& lately,
                DipolePlaces& places) noexcept {
  Vector6 p;
  p.head<3>() = PlaceOf(places.next);
  const Eigen::Matrix<double, kReadings, 3> X = MomentColumns(model, p.head<3>());
  Matrix3d A = X.transpose() * (Information(lately) * X);
  A.diagonal().array() += 1 / (options.moment_Am2 * options.moment_Am2);
  const Vector3d b = X.transpose() * Gradient(lately);
  p.tail<3>() = A.ldlt().solve(b);
  const double saved = b.dot(p.tail<3>());
  if (!(saved > places.best_saved && p.tail<3>().norm() <= options.moment_max_Am2)) return;
  places.best_saved = saved;
  places.best = places.next;
  Put(p, places.best_parameters);
}

// After all places: on from the best, if it is worth while.
void BeginSteps(const DipoleOptions& options, StrayDipole& dipole) noexcept {
  const DipolePlaces tried = *std::get_if<DipolePlaces>(&dipole.stage);
  if (!(tried.best_saved > 0.5 * options.saves)) {
    dipole.stage = DipoleStage(DipolePlaces{});
    dipole.nowhere = {};
    return;
  }
  dipole.stage = DipoleStage(DipoleSteps{.place = tried.best, .damping = kDampingStart});
  dipole.parameters = tried.best_parameters;
  dipole.covariance = {};
}

// Levenberg & Marquardt's.
void TakeStep(const DipoleOptions& options, const Model& model, DipoleSteps& steps, StrayDipole& dipole) noexcept {
  const Vector6 p = ToVector(dipole.parameters);
  const Field field = FieldAt(model, p);
  Matrix6 H = InformationAt(options, dipole.lately, field);
  H.diagonal() *= 1 + steps.damping;
  const Vector6 g = field.J.transpose() * (Gradient(dipole.lately) - Information(dipole.lately) * field.x_T) -
                    PriorInformation(options).cwiseProduct(p);
  const Vector6 next = p + H.ldlt().solve(g);
  const bool better = IsPlace(options, next) && Saved(options, dipole.lately, FieldAt(model, next).x_T, next) >=
                                                    Saved(options, dipole.lately, field.x_T, p);
  if (better) Put(next, dipole.parameters);
  steps.damping =
      better ? std::max(kDampingMin, 0.1 * steps.damping) : std::clamp(10 * steps.damping, kDampingStart, kDampingMax);
  ++steps.taken;
}

// e^T (A + A P A)^-1 e / 6: 1 of a dipole that stayed where it was.
double Innovation(const Matrix6& A, const Vector6& e, const Matrix6& P) noexcept {
  return e.dot((A + A * P * A).ldlt().solve(e)) / kN;
}

// The sensor whose gain, if it is wrong, explains most, and what of the misfit that saves.  (13.5)
struct WrongGain {
  int sensor = -1;
  double saved = 0;
};

WrongGain WorstGain(const StrayEvidence& said) noexcept {
  WrongGain worst;
  for (std::size_t i = 0; i < kSensors; ++i) {
    if (!(said.gain_information[i] > 0)) continue;
    const double saved = said.gain_gradient[i] * said.gain_gradient[i] / said.gain_information[i];
    if (saved > worst.saved) worst = {static_cast<int>(i), saved};
  }
  return worst;
}

// Of the misfit, per degree of freedom.
double LeftOf(const StrayEvidence& said, double saved) noexcept { return (said.misfit - saved) / (kDof * said.scans); }

bool Explains(const DipoleOptions& options, const StrayEvidence& said, const WrongGain& gain) noexcept {
  return gain.saved > options.gain_saves && LeftOf(said, gain.saved) < options.gain_leaves;
}

void Begin(const DipoleOptions& options, double misfit, StrayDipole& dipole) noexcept {
  dipole.stage = DipoleStage(FollowedDipole{.wander = options.wander_start, .misfit = misfit});
  dipole.lately = {};
}

// Its speed is what explains the innovations.
void LearnWander(const DipoleOptions& options, double innovation, FollowedDipole& dipole) noexcept {
  dipole.innovation += kInnovationMemory * (std::min(innovation, kInnovationMax) - dipole.innovation);
  if (dipole.innovation > options.faster) {
    dipole.wander = std::min(options.wander_grows * dipole.wander, options.wander_max);
    dipole.scans = 0;
  } else if (dipole.innovation < options.slower) {
    dipole.wander = std::max(options.wander_shrinks * dipole.wander, options.wander_min);
  }
}

}  // namespace

void SearchDipole(const DipoleOptions& options, const Model& model, StrayDipole& dipole) noexcept {
  if (!(dipole.lately.scans > 0)) return;
  if (auto* places = std::get_if<DipolePlaces>(&dipole.stage)) {
    for (int k = 0; k < options.places_a_scan; ++k) {
      const auto place = static_cast<std::size_t>(places->next);
      if (((dipole.nowhere[place / 64] >> (place % 64)) & 1U) == 0) {
        ScorePlace(options, model, dipole.lately, *places);
      }
      if (++places->next == kPlaces) return BeginSteps(options, dipole);
    }
  } else if (auto* steps = std::get_if<DipoleSteps>(&dipole.stage)) {
    for (int k = 0; k < options.steps_a_scan; ++k) TakeStep(options, model, *steps, dipole);
    if (steps->taken < options.search_steps) return;
    const auto place = static_cast<std::size_t>(steps->place);
    dipole.nowhere[place / 64] |= std::uint64_t{1} << (place % 64);
    dipole.stage = DipoleStage(DipolePlaces{});
  }
}

void StartSearch(const DipoleOptions& options, const StrayEvidence& said, int steps, StrayDipole& dipole) noexcept {
  dipole.lately = said;
  dipole.nowhere = {};
  dipole.stage = DipoleStage(DipolePlaces{});
  if (steps > 0)
    dipole.stage = DipoleStage(DipoleSteps{.taken = options.search_steps - steps, .damping = kDampingStart});
}

bool IsSearching(const StrayDipole& dipole) noexcept {
  const auto* places = std::get_if<DipolePlaces>(&dipole.stage);
  return places != nullptr ? places->next > 0 : dipole.followed() == nullptr;
}

bool FindDipole(const DipoleOptions& options, const Model& model, StrayDipole& dipole) noexcept {
  const Vector6 p = ToVector(dipole.parameters);
  if (!IsPlace(options, p)) return false;
  const Field field = FieldAt(model, p);
  const double left = std::max(1.0, LeftOf(dipole.lately, Saved(options, dipole.lately, field.x_T, p)));
  Covariance(dipole) = left * InformationAt(options, dipole.lately, field).inverse();
  if (!Covariance(dipole).allFinite()) return false;
  Begin(options, 1, dipole);
  return true;
}

void JudgeDipole(const DipoleOptions& options, const Model& model, const StrayEvidence& cycle, double repeats,
                 double systematic, StrayDipole& dipole) noexcept {
  const Vector6 p = ToVector(dipole.parameters);
  const bool started = std::holds_alternative<DipoleSteps>(dipole.stage);
  StrayEvidence& lately = dipole.lately;
  const double scans = options.keep * lately.scans + cycle.scans;
  AddEvidence(options.keep, EvidenceShare(std::min(repeats, scans), systematic), cycle, lately);
  const Field field = started ? FieldAt(model, p) : Field{};
  const double saved = started ? Saved(options, lately, field.x_T, p) : 0;
  const WrongGain gain = WorstGain(lately);
  const bool more_than_gain = saved > gain.saved + options.than_gain;
  dipole.wrong_gain = !more_than_gain && Explains(options, lately, gain) ? gain.sensor : -1;
  if (!started) return;
  const double left = LeftOf(lately, saved);
  Covariance(dipole) = std::max(1.0, left) * InformationAt(options, lately, field).inverse();
  if (!Covariance(dipole).allFinite()) {
    dipole = {};
    return;
  }
  if (more_than_gain && saved > options.saves && left < options.leaves) {
    Begin(options, std::max(1.0, left), dipole);
  }
}

// Kalman's correction in information form: p' = p + P' f e, P' = (P^-1 + f A)^-1, A = J^T D Q D J, e = -J^T D Q r.
void FollowDipole(const DipoleOptions& options, const Model& model, const StrayScan& scan, double repeats,
                  double systematic, double step_s, StrayDipole& dipole) noexcept {
  FollowedDipole& followed = *std::get_if<FollowedDipole>(&dipole.stage);
  const Field field = FieldAt(model, ToVector(dipole.parameters));
  const ReadingLanes rest = scan.Eliminate(scan.residual);
  const auto inverse_sigma = AsVector(scan.inverse_sigma);
  Matrix6 A;
  Vector6 e;
  for (int k = 0; k < kN; ++k) {
    ReadingLanes column;
    AsVector(column) = inverse_sigma.cwiseProduct(field.J.col(k));
    const ReadingLanes left = scan.Eliminate(column);
    e[k] = -AsVector(column).dot(AsVector(rest));
    A.col(k) = field.J.transpose() * inverse_sigma.cwiseProduct(AsVector(left));
  }
  Eigen::Map<Matrix6> P = Covariance(dipole);
  const double moved_m = options.speed_m_s * step_s, turned_Am2 = options.turn_1_s * options.moment_Am2 * step_s;
  P.diagonal().head<3>().array() += followed.wander * moved_m * moved_m;
  P.diagonal().tail<3>().array() += followed.wander * turned_Am2 * turned_Am2;
  LearnWander(options, Innovation(A, e, P), followed);
  followed.misfit += kMisfitMemory * (Dot(scan.residual, rest) / kDof - followed.misfit);
  const double share = EvidenceShare(std::min(repeats, ++followed.scans), systematic);
  P = (P.inverse() + share * A).inverse().eval();
  const Vector6 p = ToVector(dipole.parameters) + share * (P * e);
  if (!IsPlace(options, p) || !P.allFinite() || !(followed.misfit <= options.ends)) {
    dipole = {};
    return;
  }
  Put(p, dipole.parameters);
}

ReadingLanes FieldOfDipole(const Model& model, const StrayDipole& dipole) noexcept {
  ReadingLanes field_T;
  AsVector(field_T) = FieldAt(model, ToVector(dipole.parameters)).x_T;
  return field_T;
}

// x = x(p),   J P J^T + sigma^2
void OffsetsOfDipole(const DipoleOptions& options, const Model& model, const StrayDipole& dipole, ReadingLanes& mean_T,
                     ReadingMatrix& covariance_T2) noexcept {
  const Field field = FieldAt(model, ToVector(dipole.parameters));
  AsVector(mean_T) = field.x_T;
  auto covariance = AsMatrix<kReadings>(covariance_T2);
  covariance = field.J * Eigen::Map<const Matrix6>(dipole.covariance.data()) * field.J.transpose();
  covariance.diagonal().array() += options.other_T * options.other_T;
}

}  // namespace omni::tracker
