// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Questions to the owners of cells, and their answers (domain/cell_eigenvalues.h).

#include <dovetail/domain/cell_eigenvalues.h>
#include <dovetail/interface/trace_eigenvalue.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <utility>

namespace dovetail {

namespace {

using dealii::Tensor;

/// Of the tangent, and for the penalty.
using Pair = std::array<double, 2>;

/// What the rank that owns a cell is told of it.
template <int dim>
struct FaceOfCell
{
  unsigned int face = 0; ///< of the side, as in SideFaces
  double measure = 0;    ///< of the whole face
  std::vector<TracePoint<dim>> points;

  template <typename Archive>
  void serialize(Archive &archive, const unsigned int)
  {
    archive &face &measure &points;
  }
};

template <int dim>
using Questions = RankMap<std::vector<FaceOfCell<dim>>>;

/// How many sides of interfaces other than this one tie the field on faces of a cell.
template <int dim>
unsigned int n_other_interfaces(const InterfaceSide<dim> &side, const std::string &field,
                                const typename dealii::Triangulation<dim>::active_cell_iterator &cell)
{
  unsigned int n = 0;
  const auto others = side.others.find(field);
  if (others == side.others.end())
    return 0;
  for (const InterfaceSide<dim> *other : others->second) {
    bool has_face = false;
    for (const unsigned int face : cell->face_indices())
      has_face = has_face ||
                 (cell->face(face)->at_boundary() && other->belongs(cell, cell->face(face)->boundary_id()));
    n += has_face ? 1 : 0;
  }
  return n;
}

/// 1 if conditions prescribe the field weakly on faces of a cell.
template <int dim>
unsigned int n_weak_values(const Domain<dim> &domain, const std::string &field,
                           const typename dealii::Triangulation<dim>::active_cell_iterator &cell)
{
  for (const auto &condition : domain.conditions())
    if (condition->is_weak() && condition->field.name == field)
      for (const unsigned int face : cell->face_indices())
        if (cell->face(face)->at_boundary() &&
            condition->boundary_ids.count(cell->face(face)->boundary_id()) > 0)
          return 1;
  return 0;
}

/// Of a cell, what all ranks know of its tied faces.
template <int dim>
struct Trace
{
  std::vector<TracePoint<dim>> points;
  std::map<unsigned int, double> measures; ///< by face

  /// What penalties are multiplied by where less than a half of the faces is covered: where a tie is narrow
  /// beside the cell, the eigenvalue is small, and the cell knows no flux that varies over the tie.
  double factor_of_penalty() const
  {
    double whole = 0, covered = 0;
    for (const auto &[face, measure] : measures)
      whole += measure;
    for (const TracePoint<dim> &point : points)
      covered += point.weight;
    return covered > 0 ? std::max(1., whole / (2 * covered)) : 1;
  }
};

/// The cells of this rank behind the faces of a side.
template <int dim>
class SideProblems
{
public:
  SideProblems(const Interface<dim> &interface, const unsigned int side, const TiedField &tied);

  /// The eigenvalues of the cells behind the points that all ranks have sent.
  RankMap<std::vector<Pair>> solve(double t, const ValuesOf &unknowns, Questions<dim> questions) const;

private:
  using cell_iterator = typename dealii::Triangulation<dim>::active_cell_iterator;

  const Interface<dim> &interface;
  const InterfaceSide<dim> &interface_side;
  const Domain<dim> &domain;
  const Field &field;
  const std::vector<unsigned int> &components;
  const std::vector<cell_iterator> cell_of_face;
};

template <int dim>
SideProblems<dim>::SideProblems(const Interface<dim> &interface, const unsigned int side,
                                const TiedField &tied)
    : interface(interface), interface_side(interface.sides[side]), domain(*interface_side.domain),
      field(domain.fields()[tied.field[side]]), components(interface.components[side]),
      cell_of_face(cells_behind(interface_side))
{
}

template <int dim>
RankMap<std::vector<Pair>> SideProblems<dim>::solve(const double t, const ValuesOf &unknowns,
                                                    Questions<dim> questions) const
{
  std::map<cell_iterator, Trace<dim>> traces;
  for (auto &[rank, faces] : questions)
    for (auto &[face, measure, points] : faces) {
      Trace<dim> &trace = traces[cell_of_face[face]];
      if (!points.empty())
        trace.measures[face] = measure;
      std::move(points.begin(), points.end(), std::back_inserter(trace.points));
    }
  CellEigenvalues<dim> eigenvalues(domain, field, components, t);
  std::map<cell_iterator, Pair> lambda;
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> values;
  for (const auto &[cell, trace] : traces) {
    domain.cell_dofs(domain.dof_cell(cell), dofs);
    unknowns(dofs, values);
    Pair &pair = lambda[cell] = eigenvalues.evaluate(cell, trace.points, values);
    pair[1] *= trace.factor_of_penalty();
    for (double &value : pair)
      value *=
          1 + n_other_interfaces(interface_side, field.name, cell) + n_weak_values(domain, field.name, cell);
  }
  interface.work().eigenvalue_problems += lambda.size();

  RankMap<std::vector<Pair>> answers;
  for (const auto &[rank, faces] : questions)
    for (const auto &face : faces)
      answers[rank].push_back(lambda.at(cell_of_face[face.face]));
  return answers;
}

/// For each rank its cells behind a side; and which they are, in Pairing::cells.
template <int dim>
std::pair<Questions<dim>, RankMap<std::vector<unsigned int>>> ask_owners(const Interface<dim> &interface,
                                                                         const unsigned int side)
{
  const Pairing<dim> &pairing = interface.pairing();
  const auto &cells = pairing.cells[side];
  const unsigned int n_shapes = interface.sides[side].domain->layout().n_shapes();
  std::vector<std::vector<TracePoint<dim>>> points(cells.size());
  for (const auto &group : pairing.groups)
    for (unsigned int q = group.begin; q < group.end; ++q) {
      const double *values = pairing.values(side, q);
      const Tensor<1, dim> *gradients = pairing.gradients(side, q);
      points[group.cells[side]].push_back({pairing.weight(q),
                                           pairing.X(side, q),
                                           pairing.N(side, q),
                                           {values, values + n_shapes},
                                           {gradients, gradients + n_shapes}});
    }
  Questions<dim> questions;
  RankMap<std::vector<unsigned int>> asked;
  for (unsigned int i = 0; i < cells.size(); ++i) {
    questions[cells[i].rank].push_back({cells[i].face, cells[i].face_measure, std::move(points[i])});
    asked[cells[i].rank].push_back(i);
  }
  return {std::move(questions), std::move(asked)};
}

/// NaN where a law is not defined.
template <int dim>
TraceEigenvalues eigenvalues_at(const Interface<dim> &interface, const TiedField &field, const double t,
                                const ValuesOf &unknowns, const MPI_Comm &communicator)
{
  TraceEigenvalues result;
  for (const unsigned int side : {source, destination}) {
    const unsigned int n_cells = interface.pairing().cells[side].size();
    result.tangent_values[side].resize(n_cells);
    result.penalty_values[side].resize(n_cells);
    auto [questions, asked] = ask_owners(interface, side);
    auto answers = SideProblems<dim>(interface, side, field)
                       .solve(t, unknowns, exchange(std::move(questions), communicator, interface.work()));
    for (const auto &[rank, lambda] : exchange(std::move(answers), communicator, interface.work()))
      for (unsigned int k = 0; k < lambda.size(); ++k) {
        const unsigned int cell = asked.at(rank)[k];
        result.tangent_values[side][cell] = lambda[k][0] / field.in_jump(side);
        result.penalty_values[side][cell] = lambda[k][1] / field.in_jump(side);
      }
  }
  return result;
}

} // namespace

template <int dim>
TraceEigenvalues trace_eigenvalues(const Interface<dim> &interface, const TiedField &field, const double t,
                                   const ValuesOf &unknowns, const MPI_Comm &communicator)
{
  TraceEigenvalues lambda = eigenvalues_at(interface, field, t, unknowns, communicator);
  const auto is_undefined = [](const double value) { return std::isnan(value); };
  int is_incomplete = 0;
  for (auto &values : lambda.tangent_values) {
    is_incomplete = std::any_of(values.begin(), values.end(), is_undefined) ? 1 : is_incomplete;
    std::replace_if(values.begin(), values.end(), is_undefined, std::numeric_limits<double>::infinity());
  }
  if (dealii::Utilities::MPI::max(is_incomplete, communicator) == 0)
    return lambda;
  lambda.is_defined = false;
  const TraceEigenvalues at_rest = eigenvalues_at(
      interface, field, t,
      [](const std::vector<dealii::types::global_dof_index> &dofs, std::vector<double> &values) {
        values.assign(dofs.size(), 0.);
      },
      communicator);
  for (const unsigned int side : {source, destination})
    for (unsigned int i = 0; i < lambda.penalty_values[side].size(); ++i)
      if (is_undefined(lambda.penalty_values[side][i]))
        lambda.penalty_values[side][i] = at_rest.penalty_values[side][i];
  return lambda;
}

template TraceEigenvalues trace_eigenvalues(const Interface<2> &, const TiedField &, double, const ValuesOf &,
                                            const MPI_Comm &);
template TraceEigenvalues trace_eigenvalues(const Interface<3> &, const TiedField &, double, const ValuesOf &,
                                            const MPI_Comm &);

} // namespace dovetail
