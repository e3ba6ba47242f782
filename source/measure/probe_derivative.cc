// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/probe_derivative.h>

#include <dovetail/domain/open_boundary.h>
#include <dovetail/domain/quadrature.h>
#include <dovetail/system/unconstrained_products.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace dovetail {

namespace {

using Index = dealii::types::global_dof_index;

/// The body of the enriched model that has this name.
template <int dim>
const Domain<dim> &same_body(const Domain<dim> &domain, const Enrichment<dim> &enriched)
{
  for (const auto &other : enriched.model().domains)
    if (other->name == domain.name)
      return *other;
  Assert(false, dealii::ExcInternalError());
  return domain;
}

/// Adds weight q'(B) phi_i for all numbers of a quantity and all unknowns of a cell. Steps are small against
/// the field and against its gradient at length scales of the body, so that they have no unit.
template <int dim>
class QuantityDerivative
{
public:
  /// Collective.
  QuantityDerivative(const Domain<dim> &domain, const Quantity<dim> &quantity,
                     const Enrichment<dim> &enriched)
      : domain(domain), quantity(quantity), before(quantity.n_numbers()), after(before.size())
  {
    const auto &blocks = enriched.model().numbering->blocks();
    for (unsigned int c = 0; c < domain.n_components(); ++c) {
      double size = 0;
      for (unsigned int b = 0; b < blocks.size(); ++b)
        if (!blocks[b].is_of_multipliers &&
            enriched.model().domains[blocks[b].domain_index].get() == &domain) {
          const Field &field = domain.fields()[blocks[b].field_index];
          if (c >= field.first_component && c < field.first_component + field.n_components)
            size = enriched.x().block(b).linfty_norm();
        }
      steps.push_back(1e-4 * (size > 0 ? size : 1e-4 * domain.typical_length()));
    }
  }

  void add(DomainPoint<dim> &point, const double weight, std::vector<Vector> &result)
  {
    const CellLayout<dim> &layout = domain.layout();
    for (unsigned int c = 0; c < domain.n_components(); ++c)
      for (unsigned int direction = 0; direction <= dim; ++direction) {
        find_slopes(point, c, direction);
        for (unsigned int k = 0; k < result.size(); ++k)
          if (slopes[k] != 0)
            for (unsigned int a = 0; a < layout.n_nodes(c); ++a) {
              const unsigned int shape = layout.first_shape(c) + a;
              const double phi =
                  direction == dim ? point.shape_values()[shape] : point.shape_gradients()[shape][direction];
              result[k](point.dofs()[layout.index(c, a)]) += weight * slopes[k] * phi;
            }
      }
  }

private:
  /// Of all numbers, by the value or a derivative of a component.
  void find_slopes(DomainPoint<dim> &point, const unsigned int c, const unsigned int direction)
  {
    const double step = direction == dim ? steps[c] : steps[c] / domain.typical_length();
    const auto at = [&](const double amount, std::vector<double> &numbers) {
      point.shift(c, direction, amount);
      numbers.clear();
      quantity.evaluate(point, numbers);
    };
    at(-step, before);
    at(2 * step, after);
    point.shift(c, direction, -step);
    slopes.resize(before.size());
    for (unsigned int k = 0; k < before.size(); ++k)
      slopes[k] = (after[k] - before[k]) / (2 * step);
  }

  const Domain<dim> &domain;
  const Quantity<dim> &quantity;
  std::vector<double> steps; ///< by component
  std::vector<double> before, after, slopes;
};

template <int dim>
void add_point(const typename Probes<dim>::Probe &probe, const Domain<dim> &domain,
               const Enrichment<dim> &enriched, QuantityDerivative<dim> &derivative,
               std::vector<Vector> &result)
{
  const double n_cells =
      dealii::Utilities::MPI::sum(static_cast<double>(probe.places.size()), enriched.model().communicator);
  DomainPoint<dim> point(domain, enriched.ghosted_x(), enriched.t);
  for (const auto &[cell, unit_point] : probe.places) {
    dealii::FEValues<dim> values(domain.mapping(), domain.layout().shape_element(),
                                 dealii::Quadrature<dim>(unit_point), DomainPoint<dim>::needed());
    values.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
    point.enter(values);
    point.move_to(0);
    derivative.add(point, 1 / n_cells, result);
  }
}

template <int dim>
void add_reduction(const typename Probes<dim>::Probe &probe, const Domain<dim> &domain,
                   const Enrichment<dim> &enriched, QuantityDerivative<dim> &derivative,
                   std::vector<Vector> &result)
{
  double size = 0;
  const Region<dim> region = {&domain, probe.region.boundary_ids};
  visit_points<dim>(region, enriched.ghosted_x(), enriched.t,
                    [&](DomainPoint<dim> &, const double JxW) { size += JxW; });
  size = dealii::Utilities::MPI::sum(size, enriched.model().communicator);
  const double divisor = probe.reduce == Reduce::mean ? size : 1;
  visit_points<dim>(region, enriched.ghosted_x(), enriched.t, [&](DomainPoint<dim> &point, const double JxW) {
    derivative.add(point, JxW / divisor, result);
  });
}

/// The integral of h'(B) over the faces on which conditions give an influx h.
template <int dim>
void add_influx(const typename Probes<dim>::Probe &probe, const Domain<dim> &domain,
                const Enrichment<dim> &enriched, std::vector<Vector> &result)
{
  const CellLayout<dim> &layout = domain.layout();
  const auto &ids = probe.region.boundary_ids;
  OpenBoundary<dim> open_boundary(domain);
  std::vector<Index> dofs;
  std::vector<double> unknowns(domain.dofs_per_cell());
  for (const auto &condition : domain.conditions())
    if (condition->adds_flux() && condition->field.name == probe.field->name)
      for (const auto &[cell, face, id] : domain.boundary_faces()) {
        if (!cell->is_locally_owned() || ids.count(id) == 0 || condition->boundary_ids.count(id) == 0)
          continue;
        domain.cell_dofs(domain.dof_cell(cell), dofs);
        enriched.ghosted_x().extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
        open_boundary.for_each_point(cell, face, *condition, enriched.t, unknowns, [&](const auto &at) {
          Influx<dim> influx(probe.field->n_components, domain.n_components());
          condition->influx(at.state, at.N, influx);
          for (unsigned int c = 0; c < probe.field->n_components; ++c)
            for (unsigned int d = 0; d < domain.n_components(); ++d)
              for (unsigned int a = 0; a < layout.n_nodes(d); ++a) {
                const unsigned int shape = layout.first_shape(d) + a;
                double slope = influx.by_value(c, d) * at.shape_values[shape];
                if (condition->sees_gradients())
                  slope += influx.by_gradient(c, d) * at.shape_gradients[shape];
                if (slope != 0)
                  result[c](dofs[layout.index(d, a)]) += slope * at.JxW;
              }
        });
      }
}

/// 0: a prescribed face of the boundary of the probe, 1: another one that is prescribed, -1: neither.
template <int dim>
int part_of(const typename Domain<dim>::BoundaryFace &face, const typename Probes<dim>::Probe &probe,
            const Domain<dim> &domain, const unsigned int component, const double t)
{
  for (const auto &condition : domain.conditions())
    if (condition->field.name == probe.field->name && condition->is_active(t) &&
        domain.constrains(*condition, face, component))
      return probe.region.boundary_ids.count(face.id) > 0 ? 0 : 1;
  return -1;
}

/// Of a component c, the derivative of int A_c.N g dA over the faces of each part, with g at the nodes of a
/// cell.
template <int dim>
class FluxDerivative
{
public:
  FluxDerivative(const Domain<dim> &domain, const Enrichment<dim> &enriched)
      : domain(domain), enriched(enriched), point(domain, enriched.t),
        values(domain.mapping(), domain.layout().shape_element(),
               gauss_rule<dim - 1>(domain.face_shape(), domain.degree + 2),
               dealii::update_values | dealii::update_gradients | dealii::update_quadrature_points |
                   dealii::update_normal_vectors | dealii::update_JxW_values),
        unknowns(domain.dofs_per_cell()), g_unknowns(unknowns)
  {
  }

  /// @param c of the domain. @return whether the laws are defined.
  bool add_face(const typename Domain<dim>::BoundaryFace &face, const unsigned int c, const Vector &g,
                Vector &result)
  {
    domain.cell_dofs(domain.dof_cell(face.cell), dofs);
    g.extract_subvector_to(dofs.begin(), dofs.end(), g_unknowns.begin());
    if (std::all_of(g_unknowns.begin(), g_unknowns.end(), [](const double value) { return value == 0; }))
      return true;
    enriched.ghosted_x().extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
    values.reinit(face.cell, face.number);
    for (const unsigned int q : values.quadrature_point_indices()) {
      point.reinit(values, q, unknowns);
      if (!point.evaluate(true))
        return false;
      add_point(c, values.normal_vector(q), domain.measure(values, q), result);
    }
    return true;
  }

private:
  void add_point(const unsigned int c, const dealii::Tensor<1, dim> &N, const double JxW, Vector &result)
  {
    const CellLayout<dim> &layout = domain.layout();
    const unsigned int n = domain.n_components();
    double g_at_point = 0;
    for (unsigned int a = 0; a < layout.n_nodes(c); ++a)
      g_at_point += g_unknowns[layout.index(c, a)] * point.shape_values()[layout.first_shape(c) + a];
    for (unsigned int d = 0; d < n; ++d) {
      const dealii::Tensor<1, dim> by_gradient = N * point.response.by_gradient[c * n + d];
      const double by_value = N * point.response.by_value[c * n + d];
      for (unsigned int a = 0; a < layout.n_nodes(d); ++a) {
        const unsigned int shape = layout.first_shape(d) + a;
        result(dofs[layout.index(d, a)]) +=
            g_at_point * JxW *
            (by_gradient * point.shape_gradients()[shape] + by_value * point.shape_values()[shape]);
      }
    }
  }

  const Domain<dim> &domain;
  const Enrichment<dim> &enriched;
  CellPoints<dim> point;
  dealii::FEFaceValues<dim> values;
  std::vector<Index> dofs;
  std::vector<double> unknowns, g_unknowns;
};

/// @return nothing if a law is not defined somewhere.
template <int dim>
std::optional<ProbeDerivative>
derivative_of_resultant(const typename Probes<dim>::Probe &probe, const Domain<dim> &domain,
                        const Enrichment<dim> &enriched, const Reactions<dim> &coarse,
                        const Reactions<dim> &fine)
{
  const auto &ids = probe.region.boundary_ids;
  const Field &field = *domain.material.find_field(probe.field->name);
  std::vector<Vector> all_w;
  std::vector<std::array<Vector, 2>> all_g;
  for (unsigned int c = 0; c < field.n_components; ++c) {
    const auto lift = fine.lift(domain, ids, field, c);
    all_w.push_back(enriched.system().ghosted(lift.w));
    all_g.push_back({{enriched.system().ghosted(lift.g[0]), enriched.system().ghosted(lift.g[1])}});
  }
  auto products = unconstrained_products(enriched.model(), enriched.t, enriched.ghosted_x(), all_w);
  if (!products)
    return {};
  ProbeDerivative derivative;
  derivative.lacks = fine.resultant(domain, ids, field);
  const auto reported = coarse.resultant(*probe.region.domain, ids, *probe.field);
  for (unsigned int c = 0; c < reported.size(); ++c)
    derivative.lacks[c] -= reported[c];
  std::vector<Vector> &result = derivative.loads = std::move(products->transposed);
  add_influx(probe, domain, enriched, result);
  bool is_defined = true;
  FluxDerivative<dim> flux(domain, enriched);
  for (const auto &face : domain.boundary_faces())
    for (unsigned int c = 0; face.cell->is_locally_owned() && c < all_g.size(); ++c)
      if (const int part = part_of<dim>(face, probe, domain, c, enriched.t); part >= 0)
        is_defined =
            flux.add_face(face, probe.field->first_component + c, all_g[c][part], result[c]) && is_defined;
  if (dealii::Utilities::MPI::min(is_defined ? 1 : 0, enriched.model().communicator) == 0)
    return {};
  return derivative;
}

} // namespace

template <int dim>
std::optional<ProbeDerivative> probe_derivative(const typename Probes<dim>::Probe &probe,
                                                const Enrichment<dim> &enriched, const Reactions<dim> &coarse,
                                                const Reactions<dim> *fine)
{
  const Domain<dim> &domain = same_body(*probe.region.domain, enriched);
  ProbeDerivative result;
  if (is_resultant<dim>(probe)) {
    auto of_resultant = derivative_of_resultant(probe, domain, enriched, coarse, *fine);
    if (!of_resultant)
      return {};
    result = std::move(*of_resultant);
  } else {
    const auto quantity = probe.make_quantity(domain);
    QuantityDerivative<dim> derivative(domain, *quantity, enriched);
    result.loads.assign(quantity->n_numbers(), enriched.system().owned_vector());
    result.lacks.assign(quantity->n_numbers(), 0.);
    if (probe.X)
      add_point<dim>(probe, domain, enriched, derivative, result.loads);
    else
      add_reduction<dim>(probe, domain, enriched, derivative, result.loads);
  }
  bool is_finite = true;
  for (Vector &vector : result.loads) {
    vector.compress(dealii::VectorOperation::add);
    is_finite = is_finite && std::isfinite(vector.l2_norm());
  }
  if (!is_finite)
    return {};
  return result;
}

template std::optional<ProbeDerivative> probe_derivative(const Probes<2>::Probe &, const Enrichment<2> &,
                                                         const Reactions<2> &, const Reactions<2> *);
template std::optional<ProbeDerivative> probe_derivative(const Probes<3>::Probe &, const Enrichment<3> &,
                                                         const Reactions<3> &, const Reactions<3> *);

} // namespace dovetail
