// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Trace eigenvalues of the cells behind an interface against closed forms, in units of k G/V (scalars, k of
// the law) or (lambda + 2 mu) G/V (solids) with G the tied area of the cell: p^2 for scalars on rectangles
// and boxes, 1 for linear triangles and tetrahedra; solids as computed for squares and cubes at nu = 0, 0.3,
// 0.4999. A second interface at the same cells doubles the value, units of length and stiffness scale it, and
// a rigid rotation of a neo-Hookean body leaves it alone.
//
// ranks: 1, 2, 3

#include "../system/scene_model.h"

#include <dovetail/interface/trace_eigenvalue.h>

using namespace test;

struct Case
{
  std::string name, material, mesh_left, mesh_right;
  double stiffness; ///< k or lambda + 2 mu
  double expected;  ///< the constant C
};

template <int dim>
void check(const Case &of, const unsigned int degree, const double angle = 0)
{
  const bool is_solid = of.material.find("Solid") != std::string::npos;
  const std::string field = is_solid ? "displacement" : "temperature";
  const std::string prm =
      set("Materials", "stuff") + set("Domains", "left, right") + set("Interfaces", "seam") +
      subsection("Material stuff", of.material) +
      subsection("Domain left",
                 set("Material", "stuff") + set("Degree", std::to_string(degree)) +
                     set("Boundary conditions", "held") +
                     subsection("Boundary condition held", set("Type", "value") + set("Field", field) +
                                                               set("Boundary ids", "0") +
                                                               set("Expression", !is_solid  ? "0"
                                                                                 : dim == 2 ? "0; 0"
                                                                                            : "0; 0; 0")) +
                     of.mesh_left) +
      subsection("Domain right",
                 set("Material", "stuff") + set("Degree", std::to_string(degree)) + of.mesh_right) +
      subsection("Interface seam",
                 set("Type", "Nitsche") + set("Source", "left : 1") + set("Destination", "right : 0"));
  SceneModel<dim> scene_model(prm);
  Model<dim> &model = scene_model.model;
  const Interface<dim> &interface = *model.interfaces[0];

  // a rigid rotation about the origin
  Vector owned = BlockSystem<dim>(model).owned_vector();
  interpolate<dim>(
      model,
      [&](unsigned int, const unsigned int c, const dealii::Point<dim> &X) {
        return c == 0   ? (std::cos(angle) - 1) * X[0] - std::sin(angle) * X[1]
               : c == 1 ? std::sin(angle) * X[0] + (std::cos(angle) - 1) * X[1]
                        : 0.;
      },
      owned);
  const std::vector<double> all = gather(model, owned);
  const TraceEigenvalues lambda = trace_eigenvalues<dim>(
      interface, interface.fields[0], 1.,
      [&](const std::vector<dealii::types::global_dof_index> &dofs, std::vector<double> &values) {
        values.clear();
        for (const auto dof : dofs)
          values.push_back(all[dof]);
      },
      MPI_COMM_WORLD);

  double error = 0;
  for (const unsigned int side : {source, destination})
    for (unsigned int i = 0; i < lambda.tangent_values[side].size(); ++i) {
      const CellBehind<dim> &cell = interface.pairing().cells[side][i];
      const double constant =
          lambda.tangent_values[side][i] * cell.cell_measure / (of.stiffness * cell.face_measure);
      error = std::max(error, std::abs(constant / of.expected - 1));
      error = std::max(error, std::abs(lambda.penalty_values[side][i] / lambda.tangent_values[side][i] - 1));
    }
  report(of.name, error, of.expected == std::round(of.expected) ? 1e-10 : 5e-6);
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const auto heat = [](const std::string &k) {
    return subsection("Heat", set("Type", "Fourier") + set("Conductivity", k));
  };
  const auto solid = [](const std::string &nu, const std::string &type) {
    return subsection("Solid", set("Type", type) + set("Young modulus", "3e9") + set("Poisson ratio", nu));
  };
  const auto p_wave = [](const double nu) { return 3e9 * (1 - nu) / ((1 + nu) * (1 - 2 * nu)); };
  const std::string simplices = set("Cells", "simplices");

  for (const unsigned int p : {1, 2, 3}) {
    const std::string degree = ", degree " + std::to_string(p);
    check<2>({"rectangles" + degree, heat("2e3"), box("3, 3 : 0, 0 : 1e-3, 1e-3"),
              box("2, 2 : 1e-3, 0 : 2e-3, 1e-3"), 2e3, 1. * p * p},
             p);
    check<3>({"boxes" + degree, heat("2"), box("2, 2, 1 : 0, 0, 0 : 1, 1, 1"),
              box("1, 1, 3 : 1, 0, 0 : 1.2, 1, 1"), 2, 1. * p * p},
             p);
  }
  // the limit of thin cells tied at their long faces
  for (const unsigned int p : {1, 2, 3, 4}) {
    check<2>({"thin rectangles, degree " + std::to_string(p), heat("2e3"), box("1, 3 : 0, 0 : 1e-8, 1"),
              box("1, 2 : 1e-8, 0 : 2e-8, 1"), 2e3, 1. * p * p},
             p);
    check<2>({"thin rectangles of a solid, nu 0.4999, degree " + std::to_string(p),
              solid("0.4999", "linear elastic"), box("1, 3 : 0, 0 : 1e-8, 1"),
              box("1, 2 : 1e-8, 0 : 2e-8, 1"), p_wave(0.4999), 1. * p * p},
             p);
  }
  check<2>({"triangles", heat("2"), box("1, 1 : 0, 0 : 1, 1", simplices),
            box("1, 2 : 1, 0 : 2, 1", simplices), 2, 1},
           1);
  check<3>({"tetrahedra", heat("2"), box("1, 1, 1 : 0, 0, 0 : 1, 1, 1", simplices),
            box("1, 1, 1 : 1, 0, 0 : 2, 1, 1", simplices), 2, 1},
           1);
  check<3>({"tetrahedra of a solid", solid("0.3", "linear elastic"),
            box("1, 1, 1 : 0, 0, 0 : 1, 1, 1", simplices), box("1, 1, 1 : 1, 0, 0 : 2, 1, 1", simplices),
            p_wave(0.3), 1},
           1);

  const std::string square = box("3, 3 : 0, 0 : 1, 1"), next_square = box("4, 4 : 1, 0 : 2, 1"),
                    cube = box("2, 2, 2 : 0, 0, 0 : 1, 1, 1"), next_cube = box("3, 3, 3 : 1, 0, 0 : 2, 1, 1");
  check<2>({"squares, nu 0", solid("0", "linear elastic"), square, next_square, p_wave(0), 1.43426}, 1);
  check<2>({"squares, nu 0.3", solid("0.3", "linear elastic"), square, next_square, p_wave(0.3), 1.44822}, 1);
  check<2>({"squares, nu 0.3, degree 2", solid("0.3", "linear elastic"), square, next_square, p_wave(0.3),
            4.65320},
           2);
  check<3>({"cubes, nu 0.3", solid("0.3", "linear elastic"), cube, next_cube, p_wave(0.3), 1.66182}, 1);
  check<3>({"cubes, nu 0.4999", solid("0.4999", "linear elastic"), cube, next_cube, p_wave(0.4999), 3.99790},
           1);
  check<3>({"cubes, nu 0.3, degree 2", solid("0.3", "linear elastic"), box("1, 1, 1 : 0, 0, 0 : 1, 1, 1"),
            box("1, 1, 1 : 1, 0, 0 : 2, 1, 1"), p_wave(0.3), 5.00060},
           2);
  check<3>({"neo-Hookean cubes at rest", solid("0.3", "neo-Hookean"), cube, next_cube, p_wave(0.3), 1.66182},
           1);
  check<3>({"rotated by 130 degrees", solid("0.3", "neo-Hookean"), cube, next_cube, p_wave(0.3), 1.66182}, 1,
           130 * dealii::numbers::PI / 180);
}
