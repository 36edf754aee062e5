// The joints that the symbolic model supports.
//
// Pinocchio's default collection has 25 joint types, and every algorithm is
// instantiated for each of them. Humanoids need nine. A collection of our own
// keeps compile time and memory of this extension low.
#pragma once

#include "pinocchio/autodiff/casadi.hpp"

#include "pinocchio/multibody.hpp"

namespace pinocchio_casadi {

template <typename S, int O>
struct JointCollectionTpl {
  typedef S Scalar;
  static constexpr int Options = O;

  typedef pinocchio::JointModelRevoluteTpl<S, O, 0> JointModelRX;
  typedef pinocchio::JointModelRevoluteTpl<S, O, 1> JointModelRY;
  typedef pinocchio::JointModelRevoluteTpl<S, O, 2> JointModelRZ;
  typedef pinocchio::JointModelRevoluteUnalignedTpl<S, O> JointModelRevoluteUnaligned;
  typedef pinocchio::JointModelPrismaticTpl<S, O, 0> JointModelPX;
  typedef pinocchio::JointModelPrismaticTpl<S, O, 1> JointModelPY;
  typedef pinocchio::JointModelPrismaticTpl<S, O, 2> JointModelPZ;
  typedef pinocchio::JointModelPrismaticUnalignedTpl<S, O> JointModelPrismaticUnaligned;
  typedef pinocchio::JointModelFreeFlyerTpl<S, O> JointModelFreeFlyer;

  typedef boost::variant<JointModelRX, JointModelRY, JointModelRZ,
                         JointModelRevoluteUnaligned, JointModelPX, JointModelPY,
                         JointModelPZ, JointModelPrismaticUnaligned,
                         JointModelFreeFlyer>
      JointModelVariant;

  typedef pinocchio::JointDataRevoluteTpl<S, O, 0> JointDataRX;
  typedef pinocchio::JointDataRevoluteTpl<S, O, 1> JointDataRY;
  typedef pinocchio::JointDataRevoluteTpl<S, O, 2> JointDataRZ;
  typedef pinocchio::JointDataRevoluteUnalignedTpl<S, O> JointDataRevoluteUnaligned;
  typedef pinocchio::JointDataPrismaticTpl<S, O, 0> JointDataPX;
  typedef pinocchio::JointDataPrismaticTpl<S, O, 1> JointDataPY;
  typedef pinocchio::JointDataPrismaticTpl<S, O, 2> JointDataPZ;
  typedef pinocchio::JointDataPrismaticUnalignedTpl<S, O> JointDataPrismaticUnaligned;
  typedef pinocchio::JointDataFreeFlyerTpl<S, O> JointDataFreeFlyer;

  typedef boost::variant<JointDataRX, JointDataRY, JointDataRZ,
                         JointDataRevoluteUnaligned, JointDataPX, JointDataPY,
                         JointDataPZ, JointDataPrismaticUnaligned,
                         JointDataFreeFlyer>
      JointDataVariant;
};

typedef ::casadi::SX SX;
typedef pinocchio::ModelTpl<SX, 0, JointCollectionTpl> Model;
typedef pinocchio::DataTpl<SX, 0, JointCollectionTpl> Data;
typedef JointCollectionTpl<SX, 0> Joints;

}  // namespace pinocchio_casadi
