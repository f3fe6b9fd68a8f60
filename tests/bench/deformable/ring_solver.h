// Positive definite systems whose unknowns stand in lines, where only three lines of one ring are coupled: ring e has
// lines 2e, 2e + 1 and 2e + 2. Two lines a ring are eliminated, the third is carried on.
#pragma once

#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace omni::bench {

class RingSolver {
 public:
  explicit RingSolver(int line_size) : line_(line_size) {}

  // `rings[e]`: 3 lines x 3 lines, both triangles; what rings share is their sum. False: not positive definite.
  bool Factor(const std::vector<Eigen::MatrixXd>& rings) {
    own_.assign(rings.size(), {});
    below_.assign(rings.size(), {});
    Eigen::MatrixXd carried = Eigen::MatrixXd::Zero(line_, line_);
    for (std::size_t e = 0; e < rings.size(); ++e) {
      Eigen::MatrixXd own = rings[e].topLeftCorner(2 * line_, 2 * line_);
      own.topLeftCorner(line_, line_) += carried;
      own_[e].compute(own);
      if (own_[e].info() != Eigen::Success) return false;
      below_[e] = rings[e].bottomLeftCorner(line_, 2 * line_);
      carried = rings[e].bottomRightCorner(line_, line_) - below_[e] * own_[e].solve(below_[e].transpose());
    }
    last_.compute(carried);
    return last_.info() == Eigen::Success;
  }

  Eigen::VectorXd Solve(Eigen::VectorXd x) const {
    for (std::size_t e = 0; e < own_.size(); ++e) {
      const Eigen::Index first = 2 * static_cast<Eigen::Index>(e) * line_;
      x.segment(first, 2 * line_) = own_[e].solve(x.segment(first, 2 * line_)).eval();
      x.segment(first + 2 * line_, line_) -= below_[e] * x.segment(first, 2 * line_);
    }
    x.tail(line_) = last_.solve(x.tail(line_)).eval();
    for (std::size_t e = own_.size(); e-- > 0;) {
      const Eigen::Index first = 2 * static_cast<Eigen::Index>(e) * line_;
      x.segment(first, 2 * line_) -= own_[e].solve(below_[e].transpose() * x.segment(first + 2 * line_, line_));
    }
    return x;
  }

 private:
  int line_;
  std::vector<Eigen::LLT<Eigen::MatrixXd>> own_;
  std::vector<Eigen::MatrixXd> below_;
  Eigen::LLT<Eigen::MatrixXd> last_;
};

}  // namespace omni::bench
