// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Segments against facts: they tile every face of the side (each face's area, to 1e-13 where faces are flat,
// to 1e-10 where they are curved), and so do their shares of the other side; on affine faces products of two
// polynomials of the degree of the traces are integrated exactly; every point has a partner; on flat sides
// facing points coincide. Numbers of segments of lines and squares by hand: n + m - 1, in 3D the product of
// both directions.
//
// ranks: 1, 2, 3

#include "../system/scene_model.h"

#include <dovetail/domain/quadrature.h>

using namespace test;

struct Case
{
  std::string name, left, right;
  double length; ///< or area of the interface; 0: not known by heart
};

std::string scene(const Case &of, const unsigned int side)
{
  return set("Materials", "steel") + set("Domains", "left, right") + set("Interfaces", "seam") +
         subsection("Material steel", subsection("Heat", set("Type", "Fourier") + set("Conductivity", "1"))) +
         subsection("Domain left", set("Material", "steel") + set("Boundary conditions", "cold") +
                                       subsection("Boundary condition cold",
                                                  set("Type", "value") + set("Field", "temperature") +
                                                      set("Boundary ids", "0") + set("Expression", "0")) +
                                       of.left) +
         subsection("Domain right", set("Material", "steel") + of.right) +
         subsection("Interface seam", set("Type", "Nitsche") + set("Source", "left : 1") +
                                          set("Destination", "right : 0") +
                                          set("Integrate on", side == source ? "source" : "destination"));
}

/// A polynomial of the traces' degree, in total on triangles: products of two are integrated exactly.
template <int dim>
double polynomial(const dealii::Point<dim> &X, const unsigned int degree, const bool in_total)
{
  if (in_total)
    return std::pow(1 + X[1] - 0.7 * X[dim - 1], degree);
  double value = 1 + X[1];
  for (unsigned int i = 1; i < degree; ++i)
    value *= X[1] - 0.3 * i;
  if (dim == 3)
    for (unsigned int i = 0; i < degree; ++i)
      value *= 0.5 + i + X[2];
  return value;
}

template <int dim>
void check(const Case &of)
{
  if (is_rank_0())
    std::cout << of.name << std::endl;
  for (const unsigned int own : {source, destination}) {
    SceneModel<dim> scene_model(scene(of, own));
    const Interface<dim> &interface = *scene_model.model.interfaces[0];
    const Pairing<dim> &pairing = interface.pairing();
    const Coverage &coverage = pairing.coverage();

    // area of each own face, and of each partner's as far as this rank knows it
    std::vector<double> area(pairing.cells[own].size(), 0.);
    std::map<std::vector<dealii::types::global_dof_index>, double> area_of_partner, measure_of_partner;
    double distance = 0, total = 0, sum_of_squares = 0;
    const unsigned int degree =
        std::min(interface.sides[source].domain->degree, interface.sides[destination].domain->degree);
    const bool in_total = interface.sides[source].domain->has_simplices() &&
                          interface.sides[destination].domain->has_simplices();
    for (const auto &group : pairing.groups)
      for (unsigned int q = group.begin; q < group.end; ++q) {
        area[group.cells[own]] += pairing.weight(q);
        const CellBehind<dim> &partner = pairing.cells[1 - own][group.cells[1 - own]];
        area_of_partner[partner.dofs] +=
            pairing.weight(q) / std::abs(pairing.N(source, q) * pairing.N(destination, q));
        measure_of_partner[partner.dofs] = partner.face_measure;
        distance = std::max(distance, pairing.X(source, q).distance(pairing.X(destination, q)));
        total += pairing.weight(q);
        const double value = polynomial(pairing.X(own, q), degree, in_total);
        sum_of_squares += pairing.weight(q) * value * value;
      }
    double error = 0;
    for (unsigned int i = 0; i < area.size(); ++i)
      if (area[i] > 0)
        error = std::max(error, std::abs(area[i] / pairing.cells[own][i].face_measure - 1));
    double error_of_partner = 0;
    if (dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD) == 1)
      for (const auto &[dofs, share] : area_of_partner)
        error_of_partner = std::max(error_of_partner, std::abs(share / measure_of_partner[dofs] - 1));
    print(own == source ? "  on the source: segments, uncovered"
                        : "  on the destination: segments, uncovered",
          {double(coverage.n_segments), double(coverage.n_uncovered)});
    report("    faces", error, of.length > 0 ? 1e-13 : 1e-10);
    if (of.length > 0) {
      report("    partner's faces", error_of_partner, 1e-13);
      report("    whole", std::abs(dealii::Utilities::MPI::sum(total, MPI_COMM_WORLD) / of.length - 1),
             1e-13);
      report("    facing points", distance, 1e-14);
      // the same integral by the faces alone
      double exact = 0;
      const Domain<dim> &domain = *interface.sides[own].domain;
      dealii::FEFaceValues<dim> values(domain.mapping(), domain.scalar_element(),
                                       gauss_rule<dim - 1>(domain.face_shape(), 2 * dim * degree + 1),
                                       dealii::update_quadrature_points | dealii::update_JxW_values);
      for (const auto &[cell, face, id] : domain.boundary_faces())
        if (cell->is_locally_owned() && interface.sides[own].boundary_ids.count(id) > 0) {
          values.reinit(cell, face);
          for (const unsigned int q : values.quadrature_point_indices())
            exact += values.JxW(q) * std::pow(polynomial(values.quadrature_point(q), degree, in_total), 2);
        }
      report("    products",
             std::abs(dealii::Utilities::MPI::sum(sum_of_squares, MPI_COMM_WORLD) /
                          dealii::Utilities::MPI::sum(exact, MPI_COMM_WORLD) -
                      1),
             1e-13);
    } else
      print("    gap, angle", {coverage.largest_gap, coverage.largest_angle});
  }
}

std::string body(const std::string &arguments, const unsigned int degree = 1, const std::string &more = "")
{
  return set("Degree", std::to_string(degree)) + box(arguments, more);
}

std::string ring(const std::string &radii, const std::string &n, const unsigned int degree)
{
  return set("Degree", std::to_string(degree)) +
         subsection("Mesh", set("Generator", "hyper_shell") +
                                set("Arguments", "0, 0 : " + radii + " : " + n + " : true"));
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string simplices = set("Cells", "simplices");

  check<2>({"lines, 3 and 17", body("1, 3 : 0, 0 : 1, 1", 3), body("1, 17 : 1, 0 : 2, 1", 2), 1});
  check<2>({"lines, matching", body("1, 4 : 0, 0 : 1, 1"), body("1, 4 : 1, 0 : 2, 1"), 1});
  check<2>({"lines of triangles", body("1, 3 : 0, 0 : 1, 1", 2, simplices), body("1, 4 : 1, 0 : 2, 1"), 1});
  check<2>({"rings, degree 1", ring("0.5 : 1", "16", 1), ring("1 : 1.5", "24", 1), 0});
  check<2>({"rings, degree 3", ring("0.5 : 1", "17", 3), ring("1 : 1.5", "40", 3), 0});

  for (const unsigned int degree : {1, 2}) {
    const std::string p = ", degree " + std::to_string(degree);
    check<3>({"squares, 2 * 3 and 3 * 4" + p, body("1, 2, 3 : 0, 0, 0 : 1, 1, 1", degree),
              body("1, 3, 4 : 1, 0, 0 : 2, 1, 1", degree), 1});
    check<3>({"triangles on squares" + p, body("1, 1, 1 : 0, 0, 0 : 1, 1, 1", degree, simplices),
              body("1, 3, 2 : 1, 0, 0 : 2, 1, 1", degree), 1});
    check<3>({"triangles" + p, body("1, 1, 1 : 0, 0, 0 : 1, 1, 1", degree, simplices),
              body("1, 2, 1 : 1, 0, 0 : 2, 1, 1", degree, simplices), 1});
  }
}
