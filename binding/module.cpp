// The Python module.
#include "symbolic_model.hpp"

#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>

namespace py = pybind11;
using pinocchio_casadi::SymbolicModel;

PYBIND11_MODULE(_core, m) {
  m.doc() = "Pinocchio's algorithms over casadi::SX, as serialized CasADi functions.";
  py::class_<SymbolicModel>(m, "SymbolicModel")
      .def(py::init<const Eigen::Vector3d&>(), py::arg("gravity"))
      .def("add_joint", &SymbolicModel::add_joint, py::arg("parent"), py::arg("type"),
           py::arg("axis"), py::arg("rotation"), py::arg("translation"), py::arg("name"),
           py::arg("mass"), py::arg("lever"), py::arg("inertia"), py::arg("armature"))
      .def_property_readonly("nq", &SymbolicModel::nq)
      .def_property_readonly("nv", &SymbolicModel::nv)
      .def("mass_matrix", &SymbolicModel::mass_matrix)
      .def("bias_forces", &SymbolicModel::bias_forces)
      .def("center_of_mass", &SymbolicModel::center_of_mass)
      .def("frame", &SymbolicModel::frame, py::arg("joint"), py::arg("rotation"),
           py::arg("translation"), py::arg("name"), py::arg("local"));
}
