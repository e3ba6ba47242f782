// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_points.h>
#include <dovetail/domain/measure_by_vertices.h>
#include <dovetail/measure/bending_stiffness.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <sstream>

namespace dovetail {

namespace {

const NoteName of_bending("locking", "a solid of degree 1 bends with cells that are long beside its height");
const NoteName of_expansion("thermal stress",
                            "a solid of degree 1 cannot follow how its free expansion varies within cells");

/// Of the energy of a strain as large as the gradients and the displacement in the diameter of its cell:
/// less is that of a motion of a rigid body and rounding.
const double smallest_share = 1e-14;

/// Of the energy of the strain: less is an expansion that is nearly uniform.
const double smallest_share_of_varying = 1e-6;

/// A body that expands freely has about as much of jumps as its expansion varies within cells.
const double share_of_varying = 4;

template <int dim>
using Strain = dealii::Tensor<2, dim>;

/// Half of E : D : E, by its components.
template <int dim>
class ElasticEnergy
{
public:
  /// With the tangent at rest in the first cell of the first rank that has one. Collective.
  ElasticEnergy(const Domain<dim> &domain, const Field &displacement, const MPI_Comm &communicator)
  {
    const unsigned int n = domain.n_components(), u = displacement.first_component;
    std::vector<double> components; // of this rank
    CellPoints<dim> point(domain, 0);
    for (const auto &cell : domain.dof_handler().active_cell_iterators())
      if (cell->is_locally_owned()) {
        point.state.X = cell->center();
        for (const Field &field : domain.fields())
          if (const Expression *initial = domain.initial().find(field.name);
              initial != nullptr && field.n_components == 1)
            point.state.value[field.first_component] = initial->value(point.state.X, 0., 0);
        const bool is_evaluated = point.evaluate(true);
        for (unsigned int i = 0; i < dim && is_evaluated; ++i)
          for (unsigned int j = 0; j < dim; ++j) {
            const dealii::Tensor<2, dim> block = point.response.by_gradient[(u + i) * n + u + j];
            for (unsigned int k = 0; k < dim * dim; ++k)
              components.push_back(block[k / dim][k % dim]);
          }
        break;
      }
    for (const auto &of_rank : dealii::Utilities::MPI::all_gather(communicator, components))
      if (!is_defined && !of_rank.empty()) {
        is_defined = true;
        auto component = of_rank.begin();
        for (auto &row : tangent)
          for (auto &block : row)
            for (unsigned int k = 0; k < dim * dim; ++k)
              block[k / dim][k % dim] = *component++;
      }
  }

  double operator()(const Strain<dim> &E) const
  {
    double energy = 0;
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int j = 0; j < dim; ++j)
        energy += 0.5 * (E[i] * (tangent[i][j] * E[j]));
    return energy;
  }

  /// Of a strain of the size of H and w.
  double of_gradient(const dealii::Tensor<2, dim> &H, const dealii::Tensor<1, dim> &w) const
  {
    return 0.5 * tangent[0][0][0][0] * (H.norm_square() + w.norm_square());
  }

  /// Of a stress across the plane in plane strain, as of an isotropic solid.
  double across(const double stress) const
  {
    const double lambda = tangent[0][0][1][1], mu = tangent[0][1][0][1];
    return 0.5 * stress * stress * (lambda + mu) / (mu * (3 * lambda + 2 * mu));
  }

  bool is_defined = false;

private:
  std::array<std::array<dealii::Tensor<2, dim>, dim>, dim> tangent;
};

/// The strain without stress, by what the other fields do to the law: expansion with the temperature,
/// swelling; in 2D with what a body that is held across the plane adds to it.
template <int dim>
class FreeStrain
{
public:
  FreeStrain(const Domain<dim> &domain, const Field &displacement, const double t)
      : point(domain, t), first(displacement.first_component)
  {
    const auto &fields = domain.fields();
    for (unsigned int f = 0; f < fields.size(); ++f)
      for (unsigned int other = 0; other < fields.size(); ++other)
        exists = exists ||
                 (fields[f].has_component(first) && other != f && domain.material.flux_depends(f, other));
    for (const Field &field : fields)
      exists = exists && field.relative_degree == 0; // the values of all fields are at the vertices
  }

  /// At all points of @p values.
  const std::vector<Strain<dim>> &operator()(const dealii::FEValues<dim> &values,
                                             const std::vector<double> &unknowns)
  {
    at_points.assign(values.n_quadrature_points, Strain<dim>());
    across.assign(at_points.size(), 0.);
    for (unsigned int q = 0; exists && q < at_points.size(); ++q) {
      point.reinit(values, q, unknowns);
      for (unsigned int i = 0; i < dim; ++i)
        point.state.gradient[first + i] = 0;
      if (!point.evaluate(true))
        continue;
      at_points[q] = -1. * strain_of_stress();
      if (dim == 2 && !point.domain.measure.is_axisymmetric()) {
        for (unsigned int i = 0; i < dim; ++i)
          point.state.gradient[first + i] = at_points[q][i];
        across[q] = point.cauchy_stress()[2][2];
      }
    }
    return at_points;
  }
  Strain<dim> mean() const ///< of these points
  {
    return std::accumulate(at_points.begin(), at_points.end(), Strain<dim>()) / double(at_points.size());
  }

  /// At these points, the stress across the plane that is left with this strain; 0 in plane stress and in 3D.
  const std::vector<double> &stress_across() const { return across; }

private:
  /// By elimination with one column for each component of a symmetric strain. A tangent without stiffness in
  /// some direction tells nothing of the strain there: zero stands for it, so that all strain counts.
  Strain<dim> strain_of_stress() const
  {
    constexpr unsigned int n = dealii::SymmetricTensor<2, dim>::n_independent_components;
    const double smallest_pivot = 1e-12;
    const unsigned int n_components = point.domain.n_components();
    std::array<std::array<double, n + 1>, n> rows{}; // the stress is the last column
    for (unsigned int r = 0; r < n; ++r) {
      const auto ik = dealii::SymmetricTensor<2, dim>::unrolled_to_component_indices(r);
      for (unsigned int j = 0; j < dim; ++j)
        for (unsigned int l = 0; l < dim; ++l)
          rows[r][dealii::SymmetricTensor<2, dim>::component_to_unrolled_index({j, l})] +=
              point.response.by_gradient[(first + ik[0]) * n_components + first + j][ik[1]][l];
      rows[r][n] =
          0.5 * (point.response.flux[first + ik[0]][ik[1]] + point.response.flux[first + ik[1]][ik[0]]);
    }
    double largest = 0;
    for (unsigned int r = 0; r < n; ++r)
      largest = std::max(largest, std::abs(rows[r][r]));
    for (unsigned int r = 0; r < n; ++r) {
      if (!(rows[r][r] > smallest_pivot * largest))
        return {};
      for (unsigned int other = 0; other < n; ++other)
        if (const double factor = rows[other][r] / rows[r][r]; other != r)
          for (unsigned int c = r; c <= n; ++c)
            rows[other][c] -= factor * rows[r][c];
    }
    dealii::SymmetricTensor<2, dim> result;
    for (unsigned int r = 0; r < n; ++r)
      result.access_raw_entry(r) = rows[r][n] / rows[r][r];
    return result;
  }

  CellPoints<dim> point;
  const unsigned int first;
  bool exists = false;
  std::vector<Strain<dim>> at_points;
  std::vector<double> across;
};

template <int dim>
dealii::Tensor<2, dim> displacement_gradient(const dealii::FEValues<dim> &values, const unsigned int q,
                                             const std::vector<dealii::Tensor<1, dim>> &displacements)
{
  dealii::Tensor<2, dim> H;
  for (unsigned int a = 0; a < displacements.size(); ++a)
    H += dealii::outer_product(displacements[a], values.shape_grad(a, q));
  return H;
}

template <int dim>
Strain<dim> strain(const dealii::Tensor<2, dim> &H, const bool is_large)
{
  Strain<dim> twice = H + transpose(H);
  if (is_large)
    twice += transpose(H) * H;
  return 0.5 * twice;
}

/// Over all ranks. Collective.
StiffnessShare sum(const StiffnessShare &own, const MPI_Comm &communicator)
{
  StiffnessShare all = own;
  for (double *energy :
       {&all.jumping, &all.all, &all.across, &all.with_stress, &all.varying, &all.of_gradients})
    *energy = dealii::Utilities::MPI::sum(*energy, communicator);
  return all;
}

/// The share of the strain energy that is told to be too much; 0: none.
double share_of_jumps(const StiffnessShare &share)
{
  const bool jumps_in_all = share.jumping > largest_stiffness_share * share.all,
             jumps_with_stress = share.jumping > largest_stiffness_share * share.with_stress +
                                                     share_of_varying * share.varying;
  const double energy = jumps_in_all ? share.all : share.with_stress;
  return (jumps_in_all || jumps_with_stress) && energy > smallest_share * share.of_gradients
             ? share.jumping / energy
             : 0;
}

} // namespace

template <int dim>
StiffnessShare stiffness_share(const Domain<dim> &domain, const Field &displacement, const Vector &solution,
                               const double t, const MPI_Comm &communicator)
{
  const ElasticEnergy<dim> energy(domain, displacement, communicator);
  FreeStrain<dim> free_strain(domain, displacement, t);
  const bool is_large = domain.material.has_large_strain();
  const auto &element = domain.scalar_element();
  const unsigned int n_vertices = element.dofs_per_cell;
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns(domain.dofs_per_cell());
  std::vector<dealii::Tensor<1, dim>> displacements(n_vertices);
  const auto enter = [&](const auto &cell, dealii::FEValues<dim> &values) {
    values.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
    domain.cell_dofs(cell, dofs);
    solution.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
    for (unsigned int a = 0; a < n_vertices; ++a)
      for (unsigned int d = 0; d < dim; ++d)
        displacements[a][d] = unknowns[domain.layout().index(displacement.first_component + d, a)];
  };

  std::vector<Strain<dim>> at_vertex(domain.mesh().n_vertices());
  std::vector<double> volume_at_vertex(domain.mesh().n_vertices(), 0.);
  dealii::FEValues<dim> vertices(domain.mapping(), element,
                                 dealii::Quadrature<dim>(element.get_unit_support_points()),
                                 dealii::update_gradients);
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (!cell->is_artificial()) {
      enter(cell, vertices);
      const double volume = measure_by_vertices<dim>(cell);
      for (unsigned int a = 0; a < n_vertices; ++a) {
        at_vertex[cell->vertex_index(a)] +=
            volume * strain(displacement_gradient(vertices, a, displacements), is_large);
        volume_at_vertex[cell->vertex_index(a)] += volume;
      }
    }

  StiffnessShare share;
  dealii::FEValues<dim> values(domain.mapping(), element, domain.cell_quadrature(),
                               dealii::update_values | dealii::update_gradients | dealii::update_JxW_values |
                                   dealii::update_quadrature_points);
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned() && energy.is_defined) {
      enter(cell, values);
      const std::vector<Strain<dim>> &without_stress = free_strain(values, unknowns);
      for (const unsigned int q : values.quadrature_point_indices()) {
        const auto H = displacement_gradient(values, q, displacements);
        Strain<dim> E = strain(H, is_large), difference = E;
        dealii::Tensor<1, dim> u;
        for (unsigned int a = 0; a < n_vertices; ++a) {
          const unsigned int vertex = cell->vertex_index(a);
          difference -= values.shape_value(a, q) / volume_at_vertex[vertex] * at_vertex[vertex];
          u += values.shape_value(a, q) * displacements[a];
        }
        const double dV = domain.measure(values, q);
        share.jumping += energy(difference) * dV;
        share.all += energy(E) * dV;
        share.with_stress += energy(E - without_stress[q]) * dV;
        share.across += energy.across(free_strain.stress_across()[q]) * dV;
        share.varying += energy(without_stress[q] - free_strain.mean()) * dV;
        share.of_gradients += energy.of_gradient(H, u / cell->diameter()) * dV;
      }
    }
  return share;
}

template <int dim>
NoteList explain_stiffness(const Model<dim> &model, const Vector &solution, const double t)
{
  NoteList notes;
  for (const auto &domain : model.domains) {
    const Field *displacement = domain->material.solid_field();
    if (displacement == nullptr || domain->degree > 1)
      continue;
    const StiffnessShare share =
        sum(stiffness_share(*domain, *displacement, solution, t, model.communicator), model.communicator);
    std::ostringstream words;
    words.precision(2);
    if (const double jumps = share_of_jumps(share); jumps > 0) {
      words
          << domain->name << ": neighbouring cells of degree 1 disagree about " << 100 * jumps
          << " % of its strain energy, as in a body that bends with one to three cells across its height, or "
             "with long ones: it is too stiff by about as much, or more. Set Degree = 2, or refine the mesh";
      notes.push_back(of_bending(words.str()));
    } else if (const double of_stress = share.with_stress + share.across;
               share.varying > largest_stiffness_share * of_stress &&
               share.varying > smallest_share_of_varying * share.all) {
      words
          << domain->name
          << ": its free expansion varies within cells, and cells of degree 1 cannot follow: as much as "
          << std::lround(100 * std::min(1., std::sqrt(share.varying / of_stress)))
          << " % of its stress (root mean square) may come of that. Set Degree = 2, or refine the mesh where "
             "the temperature is steep";
      notes.push_back(of_expansion(words.str()));
    }
  }
  return notes;
}

template StiffnessShare stiffness_share(const Domain<2> &, const Field &, const Vector &, double,
                                        const MPI_Comm &);
template StiffnessShare stiffness_share(const Domain<3> &, const Field &, const Vector &, double,
                                        const MPI_Comm &);
template NoteList explain_stiffness(const Model<2> &, const Vector &, double);
template NoteList explain_stiffness(const Model<3> &, const Vector &, double);

} // namespace dovetail
