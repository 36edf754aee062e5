// Centre of mass and frames: placement, Jacobian and drift.
#include "impl.hpp"

#include "pinocchio/algorithm/center-of-mass.hpp"
#include "pinocchio/algorithm/frames.hpp"
#include "pinocchio/algorithm/jacobian.hpp"
#include "pinocchio/algorithm/kinematics.hpp"

namespace pinocchio_casadi {

std::string SymbolicModel::center_of_mass() const {
  const Model& model = impl_->model;
  const SX q = impl_->q();
  const SX v = impl_->v();
  const TangentVector zero = TangentVector::Zero(model.nv);
  Data jacobian_data(model);
  const auto& J =
      pinocchio::jacobianCenterOfMass(model, jacobian_data, to_eigen(q), false);
  Data drift_data(model);
  pinocchio::centerOfMass(model, drift_data, to_eigen(q), to_eigen(v), zero, false);
  return ::casadi::Function(
             "center_of_mass", {q, v},
             {to_casadi(jacobian_data.com[0]), to_casadi(J), to_casadi(drift_data.acom[0])},
             {"q", "v"}, {"c", "J", "drift"})
      .serialize();
}

std::string SymbolicModel::frame(int joint, const Eigen::Matrix3d& rotation,
                                 const Eigen::Vector3d& translation,
                                 const std::string& name, bool local) const {
  Model model(impl_->model);
  if (joint < 0 || joint >= model.njoints)
    throw std::invalid_argument("frame " + name + " has no parent joint of that index");
  const auto parent = static_cast<pinocchio::JointIndex>(joint);
  const pinocchio::FrameIndex id = model.addFrame(Model::Frame(
      name, parent, 0, Model::SE3(rotation.cast<SX>(), translation.cast<SX>()),
      pinocchio::OP_FRAME));
  const auto axes = local ? pinocchio::LOCAL : pinocchio::LOCAL_WORLD_ALIGNED;

  const SX q = impl_->q();
  const SX v = impl_->v();
  const TangentVector zero = TangentVector::Zero(model.nv);
  Data data(model);
  pinocchio::forwardKinematics(model, data, to_eigen(q), to_eigen(v), zero);
  pinocchio::updateFramePlacement(model, data, id);
  // with zero joint acceleration, the classical acceleration is the drift
  const auto drift = pinocchio::getFrameClassicalAcceleration(model, data, id, axes);

  Data jacobian_data(model);
  pinocchio::computeJointJacobians(model, jacobian_data, to_eigen(q));
  pinocchio::updateFramePlacement(model, jacobian_data, id);
  Data::Matrix6x J(6, model.nv);
  J.setZero();
  pinocchio::getFrameJacobian(model, jacobian_data, id, axes, J);

  return ::casadi::Function("frame", {q, v},
                            {to_casadi(data.oMf[id].translation()),
                             to_casadi(data.oMf[id].rotation()), to_casadi(J),
                             to_casadi(drift.toVector())},
                            {"q", "v"}, {"p", "R", "J", "drift"})
      .serialize();
}

}  // namespace pinocchio_casadi
