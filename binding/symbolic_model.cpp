// Construction, mass matrix and bias forces.
#include "impl.hpp"

#include "pinocchio/algorithm/crba.hpp"
#include "pinocchio/algorithm/rnea.hpp"

#include <stdexcept>

namespace pinocchio_casadi {

namespace {

Model::JointModel make_joint(const std::string& type, const Eigen::Vector3d& axis) {
  const Eigen::Matrix<SX, 3, 1> a = axis.cast<SX>();
  if (type == "JointModelFreeFlyer") return Joints::JointModelFreeFlyer();
  if (type == "JointModelRX") return Joints::JointModelRX();
  if (type == "JointModelRY") return Joints::JointModelRY();
  if (type == "JointModelRZ") return Joints::JointModelRZ();
  if (type == "JointModelPX") return Joints::JointModelPX();
  if (type == "JointModelPY") return Joints::JointModelPY();
  if (type == "JointModelPZ") return Joints::JointModelPZ();
  if (type == "JointModelRevoluteUnaligned")
    return Joints::JointModelRevoluteUnaligned(a);
  if (type == "JointModelPrismaticUnaligned")
    return Joints::JointModelPrismaticUnaligned(a);
  throw std::invalid_argument("joint type " + type + " is not supported");
}

}  // namespace

SymbolicModel::SymbolicModel(const Eigen::Vector3d& gravity)
    : impl_(std::make_unique<Impl>()) {
  impl_->model.gravity.linear() = gravity.cast<SX>();
}

SymbolicModel::~SymbolicModel() = default;

int SymbolicModel::nq() const { return impl_->model.nq; }
int SymbolicModel::nv() const { return impl_->model.nv; }

int SymbolicModel::add_joint(int parent, const std::string& type,
                             const Eigen::Vector3d& axis,
                             const Eigen::Matrix3d& rotation,
                             const Eigen::Vector3d& translation,
                             const std::string& name, double mass,
                             const Eigen::Vector3d& lever,
                             const Eigen::Matrix3d& inertia,
                             const Eigen::VectorXd& armature) {
  Model& model = impl_->model;
  if (parent < 0 || parent >= model.njoints)
    throw std::invalid_argument("joint " + name + " has no parent joint of that index");
  const Model::SE3 placement(rotation.cast<SX>(), translation.cast<SX>());
  const auto id =
      model.addJoint(static_cast<pinocchio::JointIndex>(parent), make_joint(type, axis),
                     placement, name);
  const Eigen::Matrix<SX, 3, 3> inertia_sx = inertia.cast<SX>();
  model.appendBodyToJoint(
      id, Model::Inertia(SX(mass), lever.cast<SX>(), Model::Inertia::Symmetric3(inertia_sx)),
      Model::SE3::Identity());
  const int first = model.joints[id].idx_v();
  const int size = model.joints[id].nv();
  if (armature.size() != size)
    throw std::invalid_argument("joint " + name + " needs one armature per velocity");
  model.armature.segment(first, size) = armature.cast<SX>();
  return static_cast<int>(id);
}

std::string SymbolicModel::mass_matrix() const {
  const SX q = impl_->q();
  Data data(impl_->model);
  pinocchio::crba(impl_->model, data, to_eigen(q), pinocchio::Convention::WORLD);
  // crba fills the upper triangle only
  const SX M = SX::triu2symm(SX::triu(to_casadi(data.M)));
  return ::casadi::Function("mass_matrix", {q}, {SX::densify(M)}, {"q"}, {"M"}).serialize();
}

std::string SymbolicModel::bias_forces() const {
  const SX q = impl_->q();
  const SX v = impl_->v();
  Data data(impl_->model);
  pinocchio::nonLinearEffects(impl_->model, data, to_eigen(q), to_eigen(v));
  return ::casadi::Function("bias_forces", {q, v}, {to_casadi(data.nle)}, {"q", "v"}, {"h"})
      .serialize();
}

}  // namespace pinocchio_casadi
