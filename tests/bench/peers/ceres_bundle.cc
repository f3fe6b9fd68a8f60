#include "tests/bench/peers/ceres_bundle.h"

#include <ceres/ceres.h>
#include <ceres/normal_prior.h>
#include <cmath>
#include <memory>

#include "service/calibration/fit/residual.h"
#include "service/magnetics/disc_magnet.h"

namespace omni::peers {
namespace {

using calibration::kOwn;
using calibration::kSampleShared;
using calibration::kSensorUnknowns;
using Eigen::Vector3d;
template <int kColumns>
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, kColumns, Eigen::RowMajor>;

// A sample's block: position, axis as a unit vector, remanence.
constexpr int kAmbient = 9;

calibration::Instant InstantAt(const double* block) {
  return {Eigen::Map<const Vector3d>(block), Eigen::Map<const Vector3d>(block + 3),
          Eigen::Map<const Vector3d>(block + 6)};
}

void Store(const calibration::Instant& instant, double* block) {
  Eigen::Map<Vector3d>(block, 3) = instant.position_base_m;
  Eigen::Map<Vector3d>(block + 3, 3) = instant.axis_base;
  Eigen::Map<Vector3d>(block + 6, 3) = instant.remanence;
}

// Steps of eight numbers: calibration::Moved.
class InstantManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kAmbient; }
  int TangentSize() const override { return kOwn; }

  bool Plus(const double* x, const double* step, double* sum) const override {
    const Eigen::Map<const calibration::OwnVector> by(step);
    Store(calibration::MovedInstant(InstantAt(x), by), sum);
    return true;
  }

  bool PlusJacobian(const double* x, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, kAmbient, kOwn, Eigen::RowMajor>> J(jacobian);
    const magnetics::TangentBasis basis = magnetics::MakeTangentBasis(InstantAt(x).axis_base);
    J.setZero();
    J.topLeftCorner<3, 3>().setIdentity();
    J.block<3, 1>(3, 3) = basis.e1;
    J.block<3, 1>(3, 4) = basis.e2;
    J.bottomRightCorner<3, 3>().setIdentity();
    return true;
  }

  bool Minus(const double* y, const double* x, double* difference) const override {
    const calibration::Instant to = InstantAt(y), from = InstantAt(x);
    const magnetics::TangentBasis basis = magnetics::MakeTangentBasis(from.axis_base);
    const double along = to.axis_base.dot(from.axis_base);
    Eigen::Map<calibration::OwnVector> step(difference);
    step << to.position_base_m - from.position_base_m, to.axis_base.dot(basis.e1) / along,
        to.axis_base.dot(basis.e2) / along, to.remanence - from.remanence;
    return true;
  }

  bool MinusJacobian(const double* x, double* jacobian) const override {
    Eigen::Matrix<double, kAmbient, kOwn, Eigen::RowMajor> plus;
    PlusJacobian(x, plus.data());
    Eigen::Map<Eigen::Matrix<double, kOwn, kAmbient, Eigen::RowMajor>>{jacobian} = plus.transpose();
    return true;
  }
};

// The unknowns as Ceres moves them: one block per sensor, one of the shared ones that act on samples, one per sample.
// Data of the array that all samples need is computed once per evaluation.
class Blocks final : public ceres::EvaluationCallback {
 public:
  Blocks(const calibration::Problem& problem, const calibration::Parameters& start,
         const std::vector<calibration::Instant>& instants)
      : problem_(problem), parameters_(start), own_(kAmbient * instants.size()) {
    for (std::size_t n = 0; n < instants.size(); ++n) Store(instants[n], Own(n));
  }

  void PrepareForEvaluation(bool /*jacobians*/, bool new_point) override {
    if (new_point || array_.sensors.empty()) {
      array_ = calibration::MakeArrayState(parameters_, problem_.nominal(), problem_.remanence_A());
    }
  }

  const calibration::Problem& problem() const { return problem_; }
  calibration::Parameters& parameters() { return parameters_; }
  const calibration::Parameters& parameters() const { return parameters_; }
  const calibration::ArrayState& array() const { return array_; }
  double* Sensor(int i) { return parameters_.x().data() + kSensorUnknowns * i; }
  double* Shared() { return parameters_.x().data() + parameters_.shared_at(); }
  double* Own(std::size_t n) { return own_.data() + kAmbient * n; }

 private:
  const calibration::Problem& problem_;
  calibration::Parameters parameters_;  // Ceres writes into its x
  std::vector<double> own_;
  calibration::ArrayState array_;
};

// All readings of one sample, its remanence's prior, and its touch. Blocks: sensors, shared, own.
class SampleCost final : public ceres::CostFunction {
 public:
  SampleCost(const Blocks& blocks, std::size_t n) : blocks_(blocks), observation_(blocks.problem().observations()[n]) {
    const int sensors = blocks.parameters().sensors();
    set_num_residuals(3 * sensors + 3 + (observation_.touches_hull ? 1 : 0));
    for (int i = 0; i < sensors; ++i) mutable_parameter_block_sizes()->push_back(kSensorUnknowns);
    mutable_parameter_block_sizes()->push_back(kSampleShared);
    mutable_parameter_block_sizes()->push_back(kAmbient);
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const auto sensors = static_cast<std::size_t>(blocks_.parameters().sensors());
    const calibration::Instant instant = InstantAt(blocks[sensors + 1]);
    const calibration::ToolFrame frame = calibration::MakeToolFrame(instant.position_base_m, instant.axis_base);
    const int rows = num_residuals();
    Eigen::Map<Eigen::VectorXd> r(residuals, rows);
    const auto clear = [&](std::size_t block, int columns) {
      if (jacobians != nullptr && jacobians[block] != nullptr) std::fill_n(jacobians[block], rows * columns, 0.0);
    };
    for (std::size_t i = 0; i < sensors; ++i) clear(i, kSensorUnknowns);
    clear(sensors, kSampleShared);
    clear(sensors + 1, kAmbient);
    for (std::size_t i = 0; i < sensors; ++i) AddSensor(i, instant, frame, r, jacobians);
    const int prior_at = 3 * static_cast<int>(sensors);
    r.segment<3>(prior_at) = instant.remanence;
    double* own = jacobians == nullptr ? nullptr : jacobians[sensors + 1];
    if (own != nullptr) Eigen::Map<RowMajor<kAmbient>>(own, rows, kAmbient).block<3, 3>(prior_at, 6).setIdentity();
    if (observation_.touches_hull) AddTouch(frame, r, own, jacobians == nullptr ? nullptr : jacobians[sensors]);
    return r.allFinite();
  }

 private:
  void AddSensor(std::size_t i, const calibration::Instant& instant, const calibration::ToolFrame& frame,
                 Eigen::Map<Eigen::VectorXd>& r, double** jacobians) const {
    const int at = 3 * static_cast<int>(i), rows = num_residuals();
    const calibration::Residual one =
        calibration::ComputeResidual(blocks_.parameters(), blocks_.array(), i, observation_.tau, frame,
                                     instant.remanence, observation_.kept, observation_.tool_sensor_T[i]);
    const Vector3d scale = std::sqrt(observation_.weight) * observation_.inverse_sigma[i];
    r.segment<3>(at) = scale.cwiseProduct(one.r);
    if (jacobians == nullptr) return;
    const auto sensors = static_cast<std::size_t>(blocks_.parameters().sensors());
    if (double* J = jacobians[i]; J != nullptr) {
      Eigen::Map<RowMajor<kSensorUnknowns>>(J, rows, kSensorUnknowns).middleRows<3>(at) =
          scale.asDiagonal() * one.array.leftCols<kSensorUnknowns>();
    }
    if (double* J = jacobians[sensors]; J != nullptr) {
      Eigen::Map<RowMajor<kSampleShared>>(J, rows, kSampleShared).middleRows<3>(at) =
          scale.asDiagonal() * one.array.rightCols<kSampleShared>();
    }
    if (double* J = jacobians[sensors + 1]; J != nullptr) {
      auto own = Eigen::Map<RowMajor<kAmbient>>(J, rows, kAmbient).middleRows<3>(at);
      own.leftCols<3>() = scale.asDiagonal() * one.own.leftCols<3>();
      own.middleCols<3>(3) =
          scale.asDiagonal() * (one.own.col(3) * frame.e1.transpose() + one.own.col(4) * frame.e2.transpose());
      own.rightCols<3>() = scale.asDiagonal() * one.own.rightCols<3>();
    }
  }

  void AddTouch(const calibration::ToolFrame& frame, Eigen::Map<Eigen::VectorXd>& r, double* own,
                double* shared) const {
    const calibration::TouchResidual gap = calibration::CompareTouch(blocks_.parameters(), frame);
    const double scale = std::sqrt(observation_.touch_weight) / blocks_.problem().touch_sigma_m();
    const int rows = num_residuals();
    r[rows - 1] = scale * gap.gap_m;
    if (shared != nullptr) {
      Eigen::Map<RowMajor<kSampleShared>>(shared, rows, kSampleShared).row(rows - 1) = scale * gap.by_shared;
    }
    if (own == nullptr) return;
    auto row = Eigen::Map<RowMajor<kAmbient>>(own, rows, kAmbient).row(rows - 1);
    row.leftCols<3>() = scale * gap.by_pose.leftCols<3>();
    row.middleCols<3>(3) = scale * (gap.by_pose[3] * frame.e1 + gap.by_pose[4] * frame.e2).transpose();
  }

  const Blocks& blocks_;
  const calibration::Observation& observation_;
};

// The mean gain stays 1: v.x, v all over the sensors.
class GainGauge final : public ceres::CostFunction {
 public:
  explicit GainGauge(Eigen::VectorXd direction) : direction_(std::move(direction)) {
    set_num_residuals(1);
    for (int at = 0; at + kSensorUnknowns <= direction_.size(); at += kSensorUnknowns) {
      mutable_parameter_block_sizes()->push_back(kSensorUnknowns);
    }
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    residuals[0] = 0;
    for (std::size_t i = 0; i < parameter_block_sizes().size(); ++i) {
      const Eigen::Matrix<double, kSensorUnknowns, 1> part =
          std::sqrt(calibration::kGaugeWeight) *
          direction_.segment<kSensorUnknowns>(kSensorUnknowns * static_cast<int>(i));
      residuals[0] += part.dot(Eigen::Map<const Eigen::Matrix<double, kSensorUnknowns, 1>>(blocks[i]));
      if (jacobians == nullptr || jacobians[i] == nullptr) continue;
      Eigen::Map<Eigen::Matrix<double, kSensorUnknowns, 1>>{jacobians[i]} = part;
    }
    return true;
  }

 private:
  Eigen::VectorXd direction_;  // of the sensors' unknowns
};

void AddPriors(Blocks& blocks, ceres::Problem& problem) {
  const int sensors = blocks.parameters().sensors();
  const auto unit = [](int size) {
    return new ceres::NormalPrior(Eigen::MatrixXd::Identity(size, size), Eigen::VectorXd::Zero(size));
  };
  std::vector<double*> all;
  for (int i = 0; i < sensors; ++i) {
    all.push_back(blocks.Sensor(i));
    problem.AddResidualBlock(unit(kSensorUnknowns), nullptr, blocks.Sensor(i));
  }
  problem.AddResidualBlock(unit(kSampleShared), nullptr, blocks.Shared());
  const Eigen::VectorXd v = calibration::GainScaleDirection(blocks.parameters());
  problem.AddResidualBlock(new GainGauge(v.head(kSensorUnknowns * sensors)), nullptr, all);
}

void AddSamples(Blocks& blocks, ceres::Problem& problem, ceres::ParameterBlockOrdering& ordering) {
  std::vector<double*> used;
  for (int i = 0; i < blocks.parameters().sensors(); ++i) used.push_back(blocks.Sensor(i));
  used.push_back(blocks.Shared());
  for (double* block : used) ordering.AddElementToGroup(block, 1);
  used.push_back(nullptr);
  for (std::size_t n = 0; n < blocks.problem().observations().size(); ++n) {
    used.back() = blocks.Own(n);
    problem.AddParameterBlock(blocks.Own(n), kAmbient, new InstantManifold);
    problem.AddResidualBlock(new SampleCost(blocks, n), nullptr, used);
    ordering.AddElementToGroup(blocks.Own(n), 0);
  }
}

}  // namespace

BundleFit SolveBundle(const calibration::Problem& problem, const calibration::Parameters& start,
                      const std::vector<calibration::Instant>& instants, const BundleOptions& options) {
  Blocks blocks(problem, start, instants);
  ceres::Problem::Options problem_options;
  problem_options.evaluation_callback = &blocks;
  ceres::Problem all(problem_options);
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  AddPriors(blocks, all);
  AddSamples(blocks, all, *ordering);
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.linear_solver_ordering = ordering;
  solver.max_num_iterations = options.iterations_max;
  solver.function_tolerance = options.function_tolerance;
  solver.gradient_tolerance = solver.parameter_tolerance = 0;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &all, &summary);
  BundleFit fit{blocks.parameters(), {}, 2 * summary.final_cost, static_cast<int>(summary.iterations.size()), false};
  fit.converged = summary.termination_type == ceres::CONVERGENCE;
  for (std::size_t n = 0; n < instants.size(); ++n) fit.instants.push_back(InstantAt(blocks.Own(n)));
  return fit;
}

}  // namespace omni::peers
