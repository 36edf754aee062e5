// A Pinocchio model over casadi::SX and the functions made from it.
#pragma once

#include <Eigen/Core>

#include <memory>
#include <string>

namespace pinocchio_casadi {

// Built joint by joint from plain numbers, so that nothing of libpinocchio has
// to be linked; every method returns a serialised casadi::Function.
class SymbolicModel {
 public:
  explicit SymbolicModel(const Eigen::Vector3d& gravity);
  ~SymbolicModel();

  // Adds a joint with the body it carries; returns its index. `type` is
  // Pinocchio's short name; `axis` is read for the unaligned types only.
  int add_joint(int parent, const std::string& type, const Eigen::Vector3d& axis,
                const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation,
                const std::string& name, double mass, const Eigen::Vector3d& lever,
                const Eigen::Matrix3d& inertia, const Eigen::VectorXd& armature);

  int nq() const;
  int nv() const;

  std::string mass_matrix() const;     // q -> M
  std::string bias_forces() const;     // q, v -> h
  std::string center_of_mass() const;  // q, v -> c, J, drift
  // q, v -> p, R, J, drift; J and drift in the frame's own axes if `local`,
  // else in axes parallel to the world's.
  std::string frame(int joint, const Eigen::Matrix3d& rotation,
                    const Eigen::Vector3d& translation, const std::string& name,
                    bool local) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pinocchio_casadi
