// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// On triangles and tetrahedra: ShapeEvaluator against FEValues, the measures of cells and faces against those
// of the box, and the nodes on a face against their positions.
//
// ranks: 1, 2, 3

#include "../system/scene_model.h"

#include <dovetail/domain/quadrature.h>
#include <dovetail/domain/shapes.h>

#include <deal.II/fe/fe_values.h>

using namespace test;

template <int dim>
void check(const std::string &degree)
{
  const std::string scene =
      set("Materials", "iron") + set("Domains", "body") +
      subsection("Material iron", subsection("Heat", set("Type", "Fourier") + set("Conductivity", "1"))) +
      subsection("Domain body", set("Material", "iron") + set("Degree", degree) +
                                    set("Boundary conditions", "cold") +
                                    box(dim == 2 ? "3, 2 : 0, 0 : 1, 2" : "2, 1, 2 : 0, 0, 0 : 1, 2, 3",
                                        set("Cells", "simplices")) +
                                    subsection("Boundary condition cold",
                                               set("Type", "value") + set("Field", "temperature") +
                                                   set("Boundary ids", "0") + set("Expression", "0")));
  const SceneModel<dim> built(scene);
  const Domain<dim> &domain = *built.model.domains[0];
  ShapeEvaluator<dim> evaluator(domain);
  const auto rule = gauss_rule<dim>(domain.cell_shape(), 3);
  dealii::FEValues<dim> values(domain.mapping(), domain.scalar_element(), rule,
                               dealii::update_values | dealii::update_gradients | dealii::update_JxW_values);
  dealii::FEValues<dim> at_nodes(domain.mapping(), domain.scalar_element(),
                                 domain.scalar_element().get_unit_support_points(),
                                 dealii::update_quadrature_points);
  std::vector<double> shape(domain.layout().n_nodes(0));
  std::vector<dealii::Tensor<1, dim>> gradients(domain.layout().n_nodes(0));
  double of_values = 0, of_gradients = 0, of_rule = 0, volume = 0, surface = 0;
  bool nodes_agree = true;
  for (const auto &cell : domain.mesh().active_cell_iterators())
    if (cell->is_locally_owned()) {
      values.reinit(cell);
      evaluator.reinit(cell);
      double of_cell = 0;
      for (const unsigned int q : values.quadrature_point_indices()) {
        evaluator.evaluate(rule.point(q), shape.data(), gradients.data());
        of_cell += values.JxW(q);
        for (unsigned int a = 0; a < domain.layout().n_nodes(0); ++a) {
          of_values = std::max(of_values, std::abs(shape[a] - values.shape_value(a, q)));
          of_gradients = std::max(of_gradients, (gradients[a] - values.shape_grad(a, q)).norm());
        }
      }
      volume += evaluator.cell_measure(cell);
      of_rule = std::max(of_rule, std::abs(of_cell / evaluator.cell_measure(cell) - 1));
      at_nodes.reinit(cell);
      for (const unsigned int f : cell->face_indices()) {
        if (cell->face(f)->at_boundary())
          surface += evaluator.face_measure(cell, f);
        // a node is on the face if the volume below it and the face vanishes
        const auto face = cell->face(f);
        for (unsigned int a = 0; a < domain.layout().n_nodes(0); ++a) {
          const dealii::Tensor<1, dim> r = at_nodes.quadrature_point(a) - face->vertex(0);
          double below;
          if constexpr (dim == 2)
            below = dealii::cross_product_2d(face->vertex(1) - face->vertex(0)) * r;
          else
            below = dealii::cross_product_3d(face->vertex(1) - face->vertex(0),
                                             face->vertex(2) - face->vertex(0)) *
                    r;
          nodes_agree = nodes_agree && domain.scalar_element().has_support_on_face(a, f) ==
                                           (std::abs(below) < 1e-10 * cell->measure());
        }
      }
    }
  print(std::to_string(dim) + "D, degree " + degree + ": nodes of a cell, unknowns, volume, surface, length",
        {double(domain.layout().n_nodes(0)), double(domain.dof_handler().n_dofs()),
         dealii::Utilities::MPI::sum(volume, MPI_COMM_WORLD),
         dealii::Utilities::MPI::sum(surface, MPI_COMM_WORLD), domain.typical_length()});
  report("  values", of_values, 1e-13);
  report("  gradients", of_gradients, 1e-12);
  report("  weights", of_rule, 1e-13);
  report("  nodes on faces", nodes_agree);
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  for (const std::string degree : {"1", "2"}) {
    check<2>(degree);
    check<3>(degree);
  }
}
