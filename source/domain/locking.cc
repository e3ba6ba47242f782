// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_points.h>
#include <dovetail/domain/locking.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <sstream>

namespace dovetail {

namespace {

const NoteName of_locking("locking", "a nearly incompressible solid has displacements of a low degree");

/// The scalars at the time 0.
template <int dim>
void set_scalars(const Domain<dim> &domain, State<dim> &state)
{
  for (const Field &field : domain.fields())
    if (const Expression *initial = domain.initial().find(field.name); initial && field.n_components == 1)
      state.value[field.first_component] = initial->value(state.X, 0., 0);
}

/// Of the solid at rest in the first cell of this rank; 0 if there is none, or no law that is defined.
template <int dim>
double poisson_ratio(const Domain<dim> &domain, const Field &displacement)
{
  const unsigned int n = domain.n_components(), u = displacement.first_component;
  CellPoints<dim> point(domain, 0);
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      point.state.X = cell->center();
      set_scalars(domain, point.state);
      if (!point.evaluate(true))
        return 0;
      const double along = point.response.by_gradient[u * n + u][0][0],
                   across = point.response.by_gradient[u * n + u + 1][0][1];
      return along + across > 0 ? across / (along + across) : 0;
    }
  return 0;
}

/// The largest ratio that displacements of a degree can do with.
double largest_ratio(const unsigned int degree)
{
  return degree == 1 ? 0.45 : degree == 2 ? 0.49 : 0.5;
}

} // namespace

template <int dim>
NoteList notes_on_locking(const Domain<dim> &domain, const MPI_Comm &communicator)
{
  const auto &fields = domain.fields();
  const auto displacement = std::find_if(fields.begin(), fields.end(),
                                         [](const Field &field) { return field.n_components == dim; });
  if (displacement == fields.end() || largest_ratio(domain.degree) == 0.5)
    return {};
  const double ratio = dealii::Utilities::MPI::max(poisson_ratio(domain, *displacement), communicator);
  if (ratio <= largest_ratio(domain.degree) + 1e-10)
    return {};
  const unsigned int degree = ratio <= largest_ratio(2) + 1e-10 ? 2 : 3;
  std::ostringstream words;
  words.precision(4);
  words << "with a Poisson ratio of " << ratio << " displacements of degree " << domain.degree
        << " lock: the body is too stiff, and its pressure oscillates. Set Degree = " << degree;
  if (domain.has_simplices() && degree == 3)
    words << " and take quadrilaterals or hexahedra";
  words << ", or Formulation = mixed with Degree = 2 or higher";
  return {of_locking(words.str())};
}

template NoteList notes_on_locking(const Domain<2> &, const MPI_Comm &);
template NoteList notes_on_locking(const Domain<3> &, const MPI_Comm &);

} // namespace dovetail
