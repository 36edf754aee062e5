// What the translation units of SymbolicModel share.
#pragma once

#include "joint_collection.hpp"
#include "symbolic_model.hpp"

namespace pinocchio_casadi {

typedef Model::ConfigVectorType ConfigVector;
typedef Model::TangentVectorType TangentVector;

struct SymbolicModel::Impl {
  Model model;

  SX q() const { return SX::sym("q", model.nq); }
  SX v() const { return SX::sym("v", model.nv); }
};

inline ConfigVector to_eigen(const SX& x) {
  ConfigVector y(x.size1());
  for (Eigen::Index i = 0; i < y.size(); ++i) y[i] = x(static_cast<::casadi_int>(i));
  return y;
}

template <typename Matrix>
SX to_casadi(const Eigen::MatrixBase<Matrix>& x) {
  SX y = SX::zeros(x.rows(), x.cols());
  for (Eigen::Index j = 0; j < x.cols(); ++j)
    for (Eigen::Index i = 0; i < x.rows(); ++i)
      y(static_cast<::casadi_int>(i), static_cast<::casadi_int>(j)) = x(i, j);
  return y;
}

}  // namespace pinocchio_casadi
