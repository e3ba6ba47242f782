// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Scale and Shift: the boundary ids stay, and so do the manifolds, so that after refinement all vertices and
// all points of the mapping (degree 3) on a round boundary still lie on it: relative distance at most 1e-14
// for vertices, and for points between them what the same mesh has without Scale and Shift. Volumes in units
// of Scale^dim, by the mapping of degree 4, against pi (R^2 - r^2), 4/3 pi (R^3 - r^3), pi R^2 H.
//
// ranks: 1, 2, 3

#include "../system/scene_model.h"

#include <dovetail/domain/mesh.h>

#include <deal.II/fe/mapping_q.h>
#include <deal.II/grid/grid_tools.h>

using namespace test;

template <int dim>
std::unique_ptr<Mesh<dim>> mesh_of(const std::string &generator, const std::string &arguments,
                                   const std::string &entries)
{
  const auto text = SceneText::from_prm(set("Dimension", std::to_string(dim)) + set("Generator", generator) +
                                        set("Arguments", arguments) + entries);
  return make_mesh<dim>(SceneText::root(text), MPI_COMM_WORLD);
}

/// Largest relative distance from the radii (id -> radius) of vertices and of points of the mapped faces; the
/// axis of a cylinder is x.
template <int dim>
std::pair<double, double> off_radius(const Mesh<dim> &mesh, const std::map<unsigned int, double> &radii,
                                     const dealii::Point<dim> &center, const bool is_cylinder)
{
  std::pair<double, double> distance = {0, 0};
  const dealii::MappingQ<dim> mapping(3);
  dealii::FE_Q<dim> element(1);
  dealii::FEFaceValues<dim> at(mapping, element, dealii::QGauss<dim - 1>(4),
                               dealii::update_quadrature_points);
  const auto off = [&](const dealii::Point<dim> &X, const double radius) {
    dealii::Tensor<1, dim> r = X - center;
    if (is_cylinder)
      r[0] = 0;
    return std::abs(r.norm() / radius - 1);
  };
  for (const auto &cell : mesh.active_cell_iterators())
    if (cell->is_locally_owned())
      for (const unsigned int f : cell->face_indices())
        if (cell->face(f)->at_boundary() && radii.count(cell->face(f)->boundary_id()) > 0) {
          const double radius = radii.at(cell->face(f)->boundary_id());
          for (const unsigned int v : cell->face(f)->vertex_indices())
            distance.first = std::max(distance.first, off(cell->face(f)->vertex(v), radius));
          at.reinit(cell, f);
          for (const auto &X : at.get_quadrature_points())
            distance.second = std::max(distance.second, off(X, radius));
        }
  distance.second = dealii::Utilities::MPI::max(distance.second, MPI_COMM_WORLD);
  return distance;
}

template <int dim>
void check(const std::string &generator, const std::string &arguments,
           const std::map<unsigned int, double> &radii, const double volume, const bool is_cylinder = false)
{
  const double scale = 1e-3;
  dealii::Point<dim> shift;
  std::map<unsigned int, double> scaled = radii;
  for (auto &[id, radius] : scaled)
    radius *= scale;
  for (unsigned int d = 0; d < dim; ++d)
    shift[d] = 0.002 * (d + 1);
  const auto plain = mesh_of<dim>(generator, arguments, set("Refinements", "2"));
  const auto moved = mesh_of<dim>(generator, arguments,
                                  set("Refinements", "2") + set("Scale", "1e-3") +
                                      set("Shift", dim == 2 ? "0.002; 0.004" : "0.002; 0.004; 0.006"));
  const auto of_plain = off_radius(*plain, radii, dealii::Point<dim>(), is_cylinder),
             of_moved = off_radius(*moved, scaled, shift, is_cylinder);
  report(generator + ": vertices", of_moved.first, 1e-14);
  report("points of the mapping", std::abs(of_moved.second - of_plain.second), 1e-13);
  report("which is exact enough", of_moved.second, 2e-4);
  report(
      "volume",
      std::abs(dealii::GridTools::volume(*moved, dealii::MappingQ<dim>(4)) / (volume * std::pow(scale, dim)) -
               1),
      1e-5);
  const auto plain_measures = boundary_measures<dim>(*plain), measures = boundary_measures<dim>(*moved);
  double difference = plain_measures.size() == measures.size() ? 0 : 1;
  for (const auto &[id, measure] : measures)
    difference =
        std::max(difference, std::abs(measure / std::pow(scale, dim - 1) / plain_measures.at(id) - 1));
  report("measures of the boundary ids", difference, 1e-12);
  for (const auto &[id, measure] : plain_measures)
    print("  boundary " + std::to_string(id), {measure});
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const double pi = dealii::numbers::PI;
  check<2>("hyper_shell", "0, 0 : 0.5 : 1 : 8 : true", {{0, 0.5}, {1, 1}}, pi * 0.75);
  check<2>("hyper_ball", "0, 0 : 2 : false", {{0, 2}}, pi * 4);
  check<3>("hyper_shell", "0, 0, 0 : 0.5 : 1 : 6 : true", {{0, 0.5}, {1, 1}}, 4. / 3 * pi * 0.875);
  check<3>("cylinder", "1 : 1", {{0, 1}}, 2 * pi, true);
  check<2>("subdivided_hyper_rectangle", "2, 1 : 0, 0 : 3, 1 : true", {}, 3);
  check<3>("subdivided_hyper_rectangle", "2, 1, 1 : 0, 0, 0 : 3, 1, 2 : true", {}, 6);
}
