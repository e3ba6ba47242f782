// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/error_estimate.h>

#include <dovetail/domain/cell_points.h>
#include <dovetail/domain/quadrature.h>
#include <dovetail/interface/side_points.h>

#include <deal.II/base/mpi.h>
#include <deal.II/distributed/p4est_wrappers.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/numerics/error_estimator.h>

#include <boost/serialization/map.hpp>
#include <boost/serialization/utility.hpp>

#include <array>
#include <cmath>
#include <map>

namespace dovetail {

namespace {

using Index = dealii::types::global_dof_index;

/// Of a field in a domain.
struct Scale
{
  double stiffness = 0; ///< kappa
  double energy = 0;    ///< kappa times the integral of |grad B|^2
  double noise = 0;     ///< energy that rounding of the values may have
};
using ScalesOfDomain = std::vector<Scale>; ///< by field

/// The largest dA_cJ / d(grad B_c)_J: lambda + 2 mu, or the largest conductivity in a direction.
template <int dim>
double stiffness(const Response<dim> &response, const Field &field)
{
  const unsigned int n = response.flux.size();
  double largest = 0;
  for (unsigned int c = field.first_component; c < field.first_component + field.n_components; ++c)
    for (unsigned int d = 0; d < dim; ++d)
      largest = std::max(largest, response.by_gradient[c * n + c][d][d]);
  return largest;
}

template <int dim>
ScalesOfDomain scales_of(const Domain<dim> &domain, const Vector &ghosted, const double t,
                         const MPI_Comm &communicator)
{
  const unsigned int n = domain.n_components();
  dealii::FEValues<dim> values(domain.mapping(), domain.layout().shape_element(),
                               gauss_rule<dim>(domain.cell_shape(), domain.degree + 1),
                               dealii::update_values | dealii::update_gradients |
                                   dealii::update_quadrature_points | dealii::update_JxW_values);
  // volume; per component the integrals of B^2 and |grad B|^2; volume where the law is defined at rest, and
  // per field the integral of its stiffness there: laws are asked at points of the body only
  const unsigned int n_fields = domain.fields().size(), law_index = 1 + 2 * n;
  std::vector<double> integrals(law_index + 1 + n_fields, 0.);
  CellPoints<dim> point(domain, t);
  std::vector<Index> dofs;
  std::vector<double> unknowns(domain.dofs_per_cell());
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      values.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
      domain.cell_dofs(cell, dofs);
      ghosted.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
      for (const unsigned int q : values.quadrature_point_indices()) {
        point.reinit(values, q, unknowns);
        integrals[0] += domain.measure(values, q);
        for (unsigned int c = 0; c < n; ++c) {
          const double value = point.state.value[c];
          integrals[1 + c] += value * value * domain.measure(values, q);
          integrals[1 + n + c] += point.state.gradient[c].norm_square() * domain.measure(values, q);
          point.state.gradient[c] = 0; // at rest
        }
        if (!point.evaluate(true))
          continue;
        integrals[law_index] += domain.measure(values, q);
        for (unsigned int f = 0; f < n_fields; ++f)
          integrals[law_index + 1 + f] +=
              stiffness(point.response, domain.fields()[f]) * domain.measure(values, q);
      }
    }
  dealii::Utilities::MPI::sum(integrals, communicator, integrals);

  AssertThrow(integrals[law_index] > 0,
              dealii::ExcMessage("The material of " + domain.name + " is not defined at rest."));
  ScalesOfDomain scales;
  for (unsigned int f = 0; f < n_fields; ++f) {
    const Field &field = domain.fields()[f];
    Scale scale;
    scale.stiffness = integrals[law_index + 1 + f] / integrals[law_index];
    for (unsigned int c = field.first_component; c < field.first_component + field.n_components; ++c) {
      scale.energy += scale.stiffness * integrals[1 + n + c];
      scale.noise += 1e-16 * scale.stiffness * integrals[1 + c] / std::pow(domain.typical_length(), 2);
    }
    scales.push_back(scale);
  }
  return scales;
}

/// Sums over the domains, by the name of the field; infinite where the field is constant but for rounding.
template <int dim>
std::map<std::string, double> energies_of(const Model<dim> &model, const std::vector<ScalesOfDomain> &scales)
{
  std::map<std::string, double> energy, noise;
  for (unsigned int d = 0; d < model.domains.size(); ++d)
    for (unsigned int f = 0; f < scales[d].size(); ++f) {
      energy[model.domains[d]->fields()[f].name] += scales[d][f].energy;
      noise[model.domains[d]->fields()[f].name] += scales[d][f].noise;
    }
  for (auto &[field, field_energy] : energy)
    if (field_energy <= noise[field])
      field_energy = std::numeric_limits<double>::infinity();
  return energy;
}

/// What the cells behind the points of this rank get, by their index in Pairing::cells.
using Shares = std::array<std::vector<double>, 2>;

template <int dim>
class InterfaceShares
{
public:
  InterfaceShares(const Interface<dim> &interface, const double t,
                  const std::array<const ScalesOfDomain *, 2> &scales,
                  const std::map<std::string, double> &energies)
      : interface(interface), scales(scales), energies(energies), points(interface, t)
  {
  }

  Shares evaluate(const Vector &ghosted)
  {
    Shares shares;
    for (const unsigned int side : {source, destination})
      shares[side].resize(interface.pairing().cells[side].size());
    for_each_group(interface, values_in(ghosted),
                   [&](const auto &group, const std::vector<double> &unknowns) {
                     std::array<double, 2> share = {{0, 0}}, size;
                     for (const unsigned int side : {source, destination}) {
                       const CellBehind<dim> &cell = interface.pairing().cells[side][group.cells[side]];
                       size[side] = cell.cell_measure / cell.face_measure;
                     }
                     for (unsigned int q = group.begin; q < group.end; ++q)
                       add_point(q, unknowns, size, share);
                     for (const unsigned int side : {source, destination})
                       shares[side][group.cells[side]] += share[side];
                   });
    return shares;
  }

private:
  void add_point(const unsigned int q, const std::vector<double> &unknowns, const std::array<double, 2> &size,
                 std::array<double, 2> &share)
  {
    for (const unsigned int side : {source, destination}) {
      points.reinit(side, q, unknowns);
      if (!points.evaluate(side, false))
        return;
    }
    for (const TiedField &field : interface.fields) {
      std::array<std::vector<double>, 2> flux;
      std::array<double, 2> stiffness;
      for (const unsigned int side : {source, destination}) {
        stiffness[side] = (*scales[side])[field.field[side]].stiffness;
        for (unsigned int c = 0; c < field.n_components; ++c)
          flux[side].push_back(points.response[side].flux[field.first_component[side] + c] *
                               interface.pairing().N(side, q));
      }
      interface.jump(field, q, points.state[source].t, unknowns, jump);
      numerical_flux.assign(field.n_components, 0.);
      interface.tie().numerical_flux(interface, field, q, points.state, flux, jump, numerical_flux);

      const double weight = interface.pairing().weight(q) / energies.at(field.name);
      const double mean_stiffness =
          2 * stiffness[source] * stiffness[destination] / (stiffness[source] + stiffness[destination]);
      for (const unsigned int side : {source, destination})
        for (unsigned int c = 0; c < field.n_components; ++c) {
          const double residual = flux[side][c] - (side == source ? 1 : -1) * numerical_flux[c];
          share[side] += weight * size[side] / (24 * stiffness[side]) * residual * residual;
          if (interface.tie().parts().point_terms == nullptr)
            share[side] += weight * mean_stiffness / (2 * size[side]) * jump[c] * jump[c];
        }
    }
  }

  const Interface<dim> &interface;
  const std::array<const ScalesOfDomain *, 2> scales;
  const std::map<std::string, double> &energies;
  SidePoints<dim> points;
  std::vector<double> jump, numerical_flux;
};

/// The ranks that own the cells behind the points get their shares, face by face.
template <int dim>
void add_interface(const Model<dim> &model, const Interface<dim> &interface, const Vector &ghosted,
                   const double t, const std::vector<ScalesOfDomain> &scales,
                   const std::map<std::string, double> &energies, ErrorEstimate &estimate)
{
  std::array<unsigned int, 2> domain;
  for (const unsigned int side : {source, destination})
    for (unsigned int d = 0; d < model.domains.size(); ++d)
      if (model.domains[d].get() == interface.sides[side].domain)
        domain[side] = d;
  const Shares shares =
      InterfaceShares<dim>(interface, t, {{&scales[domain[source]], &scales[domain[destination]]}}, energies)
          .evaluate(ghosted);
  for (const unsigned int side : {source, destination}) {
    std::map<unsigned int, std::map<unsigned int, double>> face_integrals; // by rank and face
    for (unsigned int i = 0; i < shares[side].size(); ++i) {
      const CellBehind<dim> &cell = interface.pairing().cells[side][i];
      face_integrals[cell.rank][cell.face] += shares[side][i];
    }
    const auto cells = cells_behind(interface.sides[side]);
    for (const auto &rank_faces : dealii::Utilities::MPI::some_to_some(model.communicator, face_integrals))
      for (const auto &[face, share] : rank_faces.second)
        estimate.squares[domain[side]][cells[face]->active_cell_index()] += share;
  }
}

} // namespace

template <int dim>
ErrorEstimate estimate_error(const Model<dim> &model, const Vector &ghosted, const double t)
{
  std::vector<ScalesOfDomain> scales;
  for (const auto &domain : model.domains)
    scales.push_back(scales_of(*domain, ghosted, t, model.communicator));
  const auto energies = energies_of(model, scales);

  ErrorEstimate estimate;
  for (unsigned int d = 0; d < model.domains.size(); ++d) {
    const Domain<dim> &domain = *model.domains[d];
    const auto solution = domain_vector(domain, ghosted);
    const auto face = domain.scalar_element().reference_cell().face_reference_cell(0);
    estimate.squares.emplace_back(domain.mesh().n_active_cells(), 0.);
    for (unsigned int f = 0; f < domain.fields().size(); ++f) {
      const Field &field = domain.fields()[f];
      dealii::ComponentMask components(domain.n_components(), false);
      for (unsigned int c = 0; c < field.n_components; ++c)
        components.set(field.first_component + c, true);
      dealii::Vector<float> eta(domain.mesh().n_active_cells());
      dealii::KellyErrorEstimator<dim>::estimate(domain.mapping(), domain.dof_handler(),
                                                 gauss_rule<dim - 1>(face, domain.degree + 1), {}, solution,
                                                 eta, components);
      for (const auto &cell : domain.mesh().active_cell_iterators())
        if (cell->is_locally_owned()) {
          const unsigned int index = cell->active_cell_index();
          estimate.squares[d][index] += scales[d][f].stiffness * std::pow<double>(eta(index), 2) *
                                        domain.measure(cell->center()) / energies.at(field.name);
        }
    }
  }
  for (const auto &interface : model.interfaces)
    if (interface->is_active(t))
      add_interface(model, *interface, ghosted, t, scales, energies, estimate);

  double sum = 0;
  for (const auto &domain_squares : estimate.squares)
    for (const double square : domain_squares)
      sum += square;
  estimate.relative = std::sqrt(dealii::Utilities::MPI::sum(sum, model.communicator));
  return estimate;
}

double marking_threshold(const std::vector<double> &squares, const double share, const MPI_Comm &communicator)
{
  const auto sum_from = [&](const double threshold) {
    double sum = 0;
    for (const double square : squares)
      if (square >= threshold)
        sum += square;
    return dealii::Utilities::MPI::sum(sum, communicator);
  };
  const double asked = share * sum_from(0) * (1 - 1e-12);
  const double largest = squares.empty() ? 0. : *std::max_element(squares.begin(), squares.end());
  double above = 2 * dealii::Utilities::MPI::max(largest, communicator), threshold = 0;
  for (unsigned int i = 0; i < 100 && above - threshold > 1e-8 * above; ++i) {
    const double middle = (threshold + above) / 2;
    (sum_from(middle) >= asked ? threshold : above) = middle;
  }

  for (double lowered = threshold;; threshold = lowered) {
    for (const double square : squares)
      if (square >= threshold * (1 - 1e-5))
        lowered = std::min(lowered, square);
    lowered = dealii::Utilities::MPI::min(lowered, communicator);
    if (lowered == threshold)
      return threshold;
  }
}

namespace {

/// Those of cells that can be divided, the others zero; p4est has a finest level.
template <int dim>
std::vector<std::vector<double>> divisible(const Model<dim> &model, const ErrorEstimate &estimate)
{
  constexpr int finest_level = dealii::internal::p4est::functions<dim>::max_level - 1;
  auto squares = estimate.squares;
  for (unsigned int d = 0; d < squares.size(); ++d)
    for (const auto &cell : model.domains[d]->mesh().active_cell_iterators())
      if (!model.domains[d]->can_refine() || cell->level() >= finest_level)
        squares[d][cell->active_cell_index()] = 0;
  return squares;
}

} // namespace

template <int dim>
bool can_refine(const Model<dim> &model, const ErrorEstimate &estimate)
{
  double largest = 0;
  for (const auto &squares : divisible(model, estimate))
    for (const double square : squares)
      largest = std::max(largest, square);
  return dealii::Utilities::MPI::max(largest, model.communicator) > 0;
}

template <int dim>
std::vector<std::vector<bool>> mark_cells(const Model<dim> &model, const ErrorEstimate &estimate,
                                          const double share)
{
  const auto by_domain = divisible(model, estimate);
  std::vector<double> squares;
  for (const auto &domain_squares : by_domain)
    squares.insert(squares.end(), domain_squares.begin(), domain_squares.end());
  const double threshold = marking_threshold(squares, share, model.communicator);
  std::vector<std::vector<bool>> marked;
  for (const auto &domain_squares : by_domain) {
    marked.emplace_back();
    for (const double square : domain_squares)
      marked.back().push_back(square > 0 && square >= threshold);
  }
  return marked;
}

template ErrorEstimate estimate_error(const Model<2> &, const Vector &, double);
template ErrorEstimate estimate_error(const Model<3> &, const Vector &, double);
template bool can_refine(const Model<2> &, const ErrorEstimate &);
template bool can_refine(const Model<3> &, const ErrorEstimate &);
template std::vector<std::vector<bool>> mark_cells(const Model<2> &, const ErrorEstimate &, double);
template std::vector<std::vector<bool>> mark_cells(const Model<3> &, const ErrorEstimate &, double);

} // namespace dovetail
