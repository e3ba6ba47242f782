// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// For tests: scenes put together from pieces of text, their models, and vectors with given values.

#pragma once

#include <dovetail/scene/scene_text.h>
#include <dovetail/system/block_system.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_q.h>

#include <cmath>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

namespace test {

using namespace dovetail;

inline bool is_rank_0()
{
  return dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0;
}

/// The largest error of all ranks against a bound.
inline void report(const std::string &what, const double error, const double bound)
{
  // the maximum loses what is not a number
  const double largest = dealii::Utilities::MPI::max(std::isfinite(error) ? error : 1e300, MPI_COMM_WORLD);
  if (!is_rank_0())
    return;
  std::cout << what << ": ";
  if (largest <= bound)
    std::cout << "ok" << std::endl;
  else
    std::cout << "error " << largest << ", bound " << bound << std::endl;
}

inline void report(const std::string &what, const bool is_true)
{
  report(what, is_true ? 0. : 1., 0.);
}

/// Rank 0 prints.
inline void print(const std::string &name, const std::vector<double> &values)
{
  if (!is_rank_0())
    return;
  std::cout << name;
  std::cout.precision(6);
  for (const double value : values)
    std::cout << ' ' << (std::abs(value) < 1e-11 ? 0. : value);
  std::cout << std::endl;
}

/// Numbers between -1 and 1, the same on every machine, one for each argument.
inline double noise(const unsigned long i)
{
  return 2 * std::fmod(std::abs(std::sin(12.9898 * (i + 1.)) * 43758.5453), 1.) - 1;
}

inline std::string subsection(const std::string &name, const std::string &entries)
{
  return "subsection " + name + "\n" + entries + "\nend\n";
}

inline std::string set(const std::string &name, const std::string &value)
{
  return "set " + name + " = " + value + "\n";
}

/// `subsection Mesh` of a box with the boundary ids 0 … 5 (x-, x+, y-, …), as the arguments of
/// subdivided_hyper_rectangle: "2, 2 : 0, 0 : 1, 1".
inline std::string box(const std::string &arguments, const std::string &more = "")
{
  return subsection("Mesh", set("Generator", "subdivided_hyper_rectangle") +
                                set("Arguments", arguments + " : true") + more);
}

template <int dim>
struct SceneModel
{
  explicit SceneModel(const std::string &prm)
      : text(SceneText::from_prm(set("Dimension", std::to_string(dim)) + prm)), scene(SceneText::root(text)),
        model(scene, MPI_COMM_WORLD)
  {
    model.pair();
  }

  std::shared_ptr<SceneText> text;
  Section scene;
  Model<dim> model;
};

/// Values of a function of domain, component and position at the owned nodes; none of discontinuous fields.
template <int dim>
using NodeFunction =
    std::function<double(unsigned int domain, unsigned int component, const dealii::Point<dim> &X)>;

template <int dim>
void interpolate(const Model<dim> &model, const NodeFunction<dim> &function, Vector &owned)
{
  for (unsigned int d = 0; d < model.domains.size(); ++d) {
    const Domain<dim> &domain = *model.domains[d];
    std::vector<dealii::types::global_dof_index> dofs;
    for (unsigned int c = 0; c < domain.n_components(); ++c) {
      if (!domain.layout().is_continuous(c))
        continue;
      const auto &element = domain.layout().element(c);
      dealii::FEValues<dim> at_nodes(domain.mapping(), element, element.get_unit_support_points(),
                                     dealii::update_quadrature_points);
      for (const auto &cell : domain.dof_handler().active_cell_iterators())
        if (cell->is_locally_owned()) {
          at_nodes.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
          domain.cell_dofs(cell, dofs);
          for (unsigned int a = 0; a < element.n_dofs_per_cell(); ++a)
            if (const auto dof = dofs[domain.layout().index(c, a)]; model.numbering->owned.is_element(dof))
              owned(dof) = function(d, c, at_nodes.quadrature_point(a));
        }
    }
  }
  owned.compress(dealii::VectorOperation::insert);
}

/// The measure of each part of the boundary with straight faces between the vertices.
template <int dim>
std::map<dealii::types::boundary_id, double> boundary_measures(const Mesh<dim> &mesh)
{
  const dealii::FE_Q<dim> element(1);
  dealii::FEFaceValues<dim> values(element, dealii::QGauss<dim - 1>(2), dealii::update_JxW_values);
  std::vector<double> measures(256, 0.);
  for (const auto &cell : mesh.active_cell_iterators())
    if (cell->is_locally_owned())
      for (const unsigned int face : cell->face_indices())
        if (cell->face(face)->at_boundary()) {
          values.reinit(cell, face);
          for (const double JxW : values.get_JxW_values())
            measures[cell->face(face)->boundary_id()] += JxW;
        }
  dealii::Utilities::MPI::sum(measures, MPI_COMM_WORLD, measures);
  std::map<dealii::types::boundary_id, double> by_id;
  for (unsigned int id = 0; id < measures.size(); ++id)
    if (measures[id] > 0)
      by_id[id] = measures[id];
  return by_id;
}

/// All unknowns of all ranks, on every rank.
template <int dim>
std::vector<double> gather(const Model<dim> &model, const Vector &owned)
{
  std::vector<double> all(model.numbering->n_dofs(), 0.);
  for (const auto dof : model.numbering->owned)
    all[dof] = owned(dof);
  dealii::Utilities::MPI::sum(all, MPI_COMM_WORLD, all);
  return all;
}

/// The unknowns of a group of points, from all unknowns.
template <int dim>
std::vector<double> of_group(const Interface<dim> &interface, const typename Pairing<dim>::Group &group,
                             const std::vector<double> &all)
{
  std::vector<dealii::types::global_dof_index> dofs;
  interface.group_dofs(group, dofs);
  std::vector<double> unknowns;
  for (const auto dof : dofs)
    unknowns.push_back(all[dof]);
  return unknowns;
}

} // namespace test
