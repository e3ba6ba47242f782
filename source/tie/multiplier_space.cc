// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/quadrature.h>
#include <dovetail/tie/multiplier_space.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/mpi_compute_index_owner_internal.h>
#include <deal.II/fe/fe_values.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

namespace {

using Index = dealii::types::global_dof_index;
using dealii::FullMatrix;

/// A node keeps its function if this share of the integral of phi_j^2 is covered. It is 1/2 where an
/// interface ends with a face, 1/4 at its corners; of two interfaces that share a face, each keeps the nodes
/// on its part.
constexpr double least_share = 0.2;
/// The coefficient of a dual function is a force over int phi_j, which around an axis vanishes at a node on
/// the axis from degree 2 on (the rule of Gauss and Lobatto is exact for phi_j r), and nearly so beside it. A
/// node keeps its function if the integral is more than this in units of that of phi_j^2; far from the axis
/// it is about 1.
constexpr double least_integral = 0.1;
/// Faces of which less is covered are not tied: their mass matrix is singular to rounding.
constexpr double least_cover = 1e-8;

/// The row vector c with c Q = q that minimises sum_i c_i^2 / w_i, for as many columns as it can be right:
/// those that depend on columns before them are left out.
std::vector<double> extrapolate(const FullMatrix<double> &Q, const std::vector<double> &q,
                                const std::vector<double> &w)
{
  const unsigned int n = Q.m();
  // Gram and Schmidt in the scalar product with the weights w
  std::vector<std::vector<double>> basis;
  std::vector<double> wanted, c(n, 0.);
  for (unsigned int k = 0; k < Q.n(); ++k) {
    std::vector<double> column(n);
    double rest = q[k], before = 0, after = 0;
    for (unsigned int i = 0; i < n; ++i) {
      column[i] = Q(i, k);
      before += w[i] * column[i] * column[i];
    }
    for (unsigned int pass = 0; pass < 2; ++pass)
      for (unsigned int l = 0; l < basis.size(); ++l) {
        double product = 0;
        for (unsigned int i = 0; i < n; ++i)
          product += w[i] * column[i] * basis[l][i];
        for (unsigned int i = 0; i < n; ++i)
          column[i] -= product * basis[l][i];
        rest -= product * wanted[l];
      }
    for (unsigned int i = 0; i < n; ++i)
      after += w[i] * column[i] * column[i];
    if (!(after > 1e-10 * before))
      continue;
    for (double &value : column)
      value /= std::sqrt(after);
    basis.push_back(column);
    wanted.push_back(rest / std::sqrt(after));
  }
  for (unsigned int l = 0; l < basis.size(); ++l)
    for (unsigned int i = 0; i < n; ++i)
      c[i] += w[i] * basis[l][i] * wanted[l];
  return c;
}

} // namespace

/// Of the tied fields on the destination.
template <int dim>
std::set<unsigned int> MultiplierSpace<dim>::spaces() const
{
  std::set<unsigned int> result;
  for (const TiedField &field : interface.fields)
    result.insert(interface.sides[destination].domain->layout().space(field.first_component[destination]));
  return result;
}

/// Of the face's space among all shape functions at a point.
template <int dim>
unsigned int MultiplierSpace<dim>::first_shape(const Face &face) const
{
  return interface.fields[face.components[0].field].first_shape[destination];
}

template <int dim>
const dealii::FiniteElement<dim> &MultiplierSpace<dim>::element(const Face &face) const
{
  return interface.sides[destination].domain->layout().element_of_space(face.space);
}

template <int dim>
void MultiplierSpace<dim>::find_nodes(Face &face) const
{
  for (unsigned int a = 0; a < element(face).n_dofs_per_cell(); ++a)
    if (element(face).has_support_on_face(a, face.number))
      face.nodes.push_back(a);
}

template <int dim>
void MultiplierSpace<dim>::find_faces()
{
  hanging = interface.sides[destination].domain->hanging_nodes();
  faces.clear();
  face_of_point.clear();
  for (const unsigned int space : spaces())
    find_faces(space);
  const auto is_tiny = [&](const Face &face) {
    double area = 0;
    for (unsigned int i = 0; i < face.mass.m(); ++i)
      for (unsigned int j = 0; j < face.mass.m(); ++j)
        area += face.mass(i, j);
    return area < least_cover * interface.pairing().cells[destination][face.cell].face_measure;
  };
  for (Face &face : faces)
    if (is_tiny(face))
      face.groups.clear();
}

template <int dim>
void MultiplierSpace<dim>::find_faces(const unsigned int space)
{
  const Pairing<dim> &pairing = interface.pairing();
  const SideFaces<dim> side_faces = faces_of(interface.sides[destination]);
  std::vector<unsigned int> &faces_of_points = face_of_point[space];
  faces_of_points.assign(pairing.n_points(), dealii::numbers::invalid_unsigned_int);
  std::map<unsigned int, unsigned int> face_of_cell;
  for (unsigned int g = 0; g < pairing.groups.size(); ++g) {
    const auto &group = pairing.groups[g];
    const unsigned int cell = group.cells[destination];
    const auto [entry, is_new] = face_of_cell.emplace(cell, faces.size());
    if (is_new) {
      Face face;
      face.cell = cell;
      face.number = side_faces.faces[pairing.cells[destination][cell].face].face_no;
      face.space = space;
      find_nodes(face);
      find_components(face, pairing.cells[destination][cell].dofs);
      face.mass.reinit(face.nodes.size(), face.nodes.size());
      faces.push_back(std::move(face));
    }
    Face &face = faces[entry->second];
    face.groups.push_back(g);
    for (unsigned int q = group.begin; q < group.end; ++q) {
      faces_of_points[q] = entry->second;
      const double *phi = pairing.values(destination, q) + first_shape(face);
      for (unsigned int i = 0; i < face.nodes.size(); ++i)
        for (unsigned int j = 0; j < face.nodes.size(); ++j)
          face.mass(i, j) += pairing.weight(q) * phi[face.nodes[i]] * phi[face.nodes[j]];
    }
  }
}

template <int dim>
void MultiplierSpace<dim>::find_components(Face &face, const std::vector<Index> &cell_dofs) const
{
  const Domain<dim> &domain = *interface.sides[destination].domain;
  const unsigned int n = face.nodes.size();
  for (unsigned int f = 0; f < interface.fields.size(); ++f)
    for (unsigned int c = 0; c < interface.fields[f].n_components; ++c) {
      const unsigned int domain_component = interface.fields[f].first_component[destination] + c;
      if (domain.layout().space(domain_component) != face.space)
        continue;
      Component component;
      component.field = f;
      component.component = c;
      std::vector<std::map<Index, double>> node_weights(n);
      for (unsigned int a = 0; a < n; ++a) {
        const Index dof = cell_dofs[domain.layout().index(domain_component, face.nodes[a])];
        if (hanging.is_constrained(dof - domain.first_dof())) {
          for (const auto &[master, weight] : *hanging.get_constraint_entries(dof - domain.first_dof()))
            node_weights[a][domain.first_dof() + master] += weight;
        } else
          node_weights[a][dof] = 1;
      }
      std::map<Index, unsigned int> column;
      for (const auto &entries : node_weights)
        for (const auto &entry : entries)
          if (std::abs(entry.second) > 1e-14)
            column.emplace(entry.first, 0);
      for (auto &[dof, position] : column) {
        position = component.dofs.size();
        component.dofs.push_back(dof);
      }
      component.C.reinit(n, column.size());
      for (unsigned int a = 0; a < n; ++a)
        for (const auto &[dof, weight] : node_weights[a])
          if (const auto found = column.find(dof); found != column.end())
            component.C(a, found->second) = weight;
      face.components.push_back(std::move(component));
    }
}

template <int dim>
void MultiplierSpace<dim>::add_full_masses(std::map<Index, Shares> &shares) const
{
  const InterfaceSide<dim> &side = interface.sides[destination];
  const Domain<dim> &domain = *side.domain;
  std::vector<Index> dofs;
  for (const unsigned int space : spaces()) {
    dealii::FEFaceValues<dim> values(domain.mapping(), domain.layout().element_of_space(space),
                                     gauss_rule<dim - 1>(domain.face_shape(), domain.degree + 1),
                                     dealii::update_values | domain.measure.update_flags());
    for (const auto &side_face : faces_of(side).faces) {
      values.reinit(side_face.cell, side_face.face_no);
      domain.cell_dofs(domain.dof_cell(side_face.cell), dofs);
      Face face;
      face.number = side_face.face_no;
      face.space = space;
      find_nodes(face);
      find_components(face, dofs);
      for (const Component &component : face.components)
        for (unsigned int i = 0; i < component.dofs.size(); ++i)
          for (const unsigned int q : values.quadrature_point_indices()) {
            double phi = 0;
            for (unsigned int a = 0; a < face.nodes.size(); ++a)
              phi += component.C(a, i) * values.shape_value(face.nodes[a], q);
            shares[component.dofs[i]].full += domain.measure(values, q) * phi * phi;
          }
    }
  }
}

/// Unknowns of the destination's nodes that also lie on a boundary which another interface takes or
/// multiplies.
template <int dim>
std::set<Index> MultiplierSpace<dim>::cross_points() const
{
  const InterfaceSide<dim> &side = interface.sides[destination];
  const Domain<dim> &domain = *side.domain;
  std::set<Index> found;
  std::vector<Index> dofs;
  for (const TiedField &field : interface.fields) {
    const auto others = side.strong_others.find(field.names[destination]);
    if (others == side.strong_others.end())
      continue;
    const unsigned int first = field.first_component[destination];
    const auto &element = domain.layout().element(first);
    for (const auto &[cell, face, id] : domain.boundary_faces())
      if (!side.belongs(cell, id) &&
          std::any_of(others->second.begin(), others->second.end(),
                      [&cell = cell, id = id](const auto *other) { return other->belongs(cell, id); })) {
        domain.cell_dofs(domain.dof_cell(cell), dofs);
        for (unsigned int c = 0; c < field.n_components; ++c)
          for (unsigned int a = 0; a < element.n_dofs_per_cell(); ++a)
            if (element.has_support_on_face(a, face))
              found.insert(dofs[domain.layout().index(first + c, a)]);
      }
  }
  return found;
}

/// Which unknowns on this rank's faces have a function of their own. Their owners decide.
template <int dim>
std::map<Index, bool> MultiplierSpace<dim>::decide(const TieConstraints &constraints,
                                                   const MPI_Comm &communicator)
{
  std::map<Index, Shares> shares;
  for (const Face &face : faces)
    if (!face.groups.empty())
      for (const Component &component : face.components)
        for (unsigned int i = 0; i < component.dofs.size(); ++i)
          for (unsigned int a = 0; a < face.nodes.size(); ++a)
            for (unsigned int b = 0; b < face.nodes.size(); ++b) {
              shares[component.dofs[i]].covered += component.C(a, i) * face.mass(a, b) * component.C(b, i);
              shares[component.dofs[i]].integral += component.C(a, i) * face.mass(a, b);
            }
  add_full_masses(shares);

  std::set<Index> all;
  for (const auto &dof_share : shares)
    all.insert(dof_share.first);
  const Domain<dim> &domain = *interface.sides[destination].domain;
  owner_of = owners(all, domain.first_dof(), domain.dof_handler().locally_owned_dofs(), communicator);
  RankMap<std::map<Index, Shares>> questions;
  for (const auto &[dof, share] : shares)
    questions[owner_of.at(dof)][dof] = share;
  const auto asked = exchange(std::move(questions), communicator, interface.work());
  std::map<Index, Shares> sums;
  for (const auto &rank_part : asked)
    for (const auto &[dof, share] : rank_part.second) {
      sums[dof].covered += share.covered;
      sums[dof].full += share.full;
      sums[dof].integral += share.integral;
    }
  const std::set<Index> crossing = cross_points();
  std::map<Index, bool> keeps;
  std::array<unsigned long, 4> counts = {{0, 0, 0, 0}};
  for (const auto &[dof, sum] : sums) {
    const bool is_taken = constraints.has(dof) || crossing.count(dof) > 0;
    const bool is_touched = sum.covered > 0;
    const bool is_without_weight =
        is_dual && domain.measure.is_axisymmetric() && std::abs(sum.integral) <= least_integral * sum.covered;
    keeps[dof] = !is_taken && !is_without_weight && sum.covered >= least_share * sum.full;
    counts[0] += keeps[dof] ? 1 : 0;
    counts[1] += is_touched && is_taken ? 1 : 0;
    counts[2] += is_touched && !is_taken && !is_without_weight && !keeps[dof] ? 1 : 0;
    counts[3] += is_touched && !is_taken && is_without_weight ? 1 : 0;
  }
  n_rows = dealii::Utilities::MPI::sum(counts[0], communicator);
  n_taken = dealii::Utilities::MPI::sum(counts[1], communicator);
  n_hardly_covered = dealii::Utilities::MPI::sum(counts[2], communicator);
  n_on_axis = dealii::Utilities::MPI::sum(counts[3], communicator);

  RankMap<std::map<Index, bool>> answers;
  for (const auto &[rank, rank_part] : asked)
    for (const auto &dof_share : rank_part)
      answers[rank][dof_share.first] = keeps.at(dof_share.first);
  std::map<Index, bool> result;
  for (auto &rank_part : exchange(std::move(answers), communicator, interface.work()))
    result.merge(rank_part.second);
  return result;
}

/// Of the face's nodes, from -1 to 1 along the edges.
template <int dim>
FullMatrix<double> MultiplierSpace<dim>::node_coordinates(const Face &face) const
{
  const auto &face_element = element(face);
  const FaceShape<dim> shape(face_element.reference_cell(), 1);
  const auto origin = shape.position_in_cell(face.number, shape.corner(0));
  std::array<dealii::Tensor<1, dim>, dim - 1> axis;
  for (unsigned int d = 0; d < dim - 1; ++d)
    axis[d] = shape.position_in_cell(face.number, shape.corner(d == 0 ? 1 : shape.n_corners() - 1)) - origin;
  FullMatrix<double> metric(dim - 1, dim - 1); // the axes of a triangle are not orthogonal
  for (unsigned int d = 0; d < dim - 1; ++d)
    for (unsigned int e = 0; e < dim - 1; ++e)
      metric(d, e) = axis[d] * axis[e];
  metric.gauss_jordan();
  FullMatrix<double> coordinates(face.nodes.size(), dim - 1);
  for (unsigned int a = 0; a < face.nodes.size(); ++a)
    for (unsigned int d = 0; d < dim - 1; ++d) {
      coordinates(a, d) = -1;
      for (unsigned int e = 0; e < dim - 1; ++e)
        coordinates(a, d) +=
            2 * metric(d, e) * (axis[e] * (face_element.unit_support_point(face.nodes[a]) - origin));
    }
  return coordinates;
}

/// The values at the face's nodes of a basis of the polynomials of a degree on the reference face, low
/// degrees first.
template <int dim>
FullMatrix<double> MultiplierSpace<dim>::polynomials(const Face &face, const unsigned int degree) const
{
  const bool is_simplex = interface.sides[destination].domain->has_simplices();
  const FullMatrix<double> coordinates = node_coordinates(face);
  std::vector<std::array<unsigned int, 2>> exponents;
  for (unsigned int sum = 0; sum <= (is_simplex || dim == 2 ? 1 : 2) * degree; ++sum)
    for (unsigned int j = 0; j <= (dim == 2 ? 0 : std::min(sum, degree)); ++j)
      if (sum - j <= degree)
        exponents.push_back({{sum - j, j}});
  FullMatrix<double> values(face.nodes.size(), exponents.size());
  for (unsigned int a = 0; a < face.nodes.size(); ++a)
    for (unsigned int k = 0; k < exponents.size(); ++k) {
      values(a, k) = 1;
      for (unsigned int d = 0; d < dim - 1; ++d)
        values(a, k) *= std::pow(coordinates(a, d), exponents[k][d]);
    }
  return values;
}

/// The coefficients at all nodes (columns) of the functions eta_j of the nodes that have one (rows): phi_j
/// and what it takes over from nodes without.
template <int dim>
FullMatrix<double> MultiplierSpace<dim>::extend(const Face &face, Component &component,
                                                const std::vector<unsigned int> &kept) const
{
  const unsigned int n = face.nodes.size(), m = component.dofs.size(), p = element(face).degree;
  FullMatrix<double> eta(kept.size(), m);
  for (unsigned int j = 0; j < kept.size(); ++j)
    eta(j, kept[j]) = 1;
  if (kept.size() == m)
    return eta;
  Assert(m == n, dealii::ExcInternalError());
  FullMatrix<double> inverse_C(m, n);
  inverse_C.invert(component.C);
  const FullMatrix<double> at_nodes = polynomials(face, p - 1);
  FullMatrix<double> coefficients(m, at_nodes.n()), kept_coefficients(kept.size(), at_nodes.n()),
      coordinates(m, dim - 1);
  inverse_C.mmult(coefficients, at_nodes);
  inverse_C.mmult(coordinates, node_coordinates(face));
  for (unsigned int j = 0; j < kept.size(); ++j)
    for (unsigned int k = 0; k < at_nodes.n(); ++k)
      kept_coefficients(j, k) = coefficients(kept[j], k);
  std::vector<double> wanted(at_nodes.n()), weights(kept.size());
  for (unsigned int i = 0; i < m; ++i)
    if (!component.has_function[i]) {
      for (unsigned int k = 0; k < at_nodes.n(); ++k)
        wanted[k] = coefficients(i, k);
      for (unsigned int j = 0; j < kept.size(); ++j) {
        double square = 0;
        for (unsigned int d = 0; d < dim - 1; ++d)
          square += std::pow(coordinates(i, d) - coordinates(kept[j], d), 2);
        weights[j] = 1 / (square * square); // near nodes take over
      }
      const std::vector<double> c = extrapolate(kept_coefficients, wanted, weights);
      for (unsigned int j = 0; j < kept.size(); ++j) {
        eta(j, i) = c[j];
        component.extrapolation.emplace_back(i, kept[j], c[j]);
      }
    }
  return eta;
}

template <int dim>
void MultiplierSpace<dim>::make_functions(Face &face) const
{
  for (Component &component : face.components) {
    const unsigned int n = face.nodes.size(), m = component.dofs.size();
    std::vector<unsigned int> kept;
    for (unsigned int i = 0; i < m; ++i)
      if (component.has_function[i])
        kept.push_back(i);
    const unsigned int n_kept = kept.size();
    component.psi.reinit(m, m);
    component.mass.reinit(m, m);
    if (n_kept == 0)
      continue;
    FullMatrix<double> MC(n, m), M(m, m);
    face.mass.mmult(MC, component.C);
    component.C.Tmmult(M, MC);

    FullMatrix<double> psi = extend(face, component, kept), mass(n_kept, m);
    if (is_dual) {
      FullMatrix<double> N(n_kept, n_kept), B(n_kept, n_kept);
      psi.mmult(mass, M);
      for (unsigned int l = 0; l < n_kept; ++l)
        for (unsigned int i = 0; i < n_kept; ++i)
          N(l, i) = mass(l, kept[i]);
      B.invert(N);
      for (unsigned int j = 0; j < n_kept; ++j) {
        double integral = 0; // of phi_j: the sum of all phi is 1
        for (unsigned int i = 0; i < m; ++i)
          integral += M(i, kept[j]);
        for (unsigned int l = 0; l < n_kept; ++l)
          B(j, l) *= integral;
      }
      const FullMatrix<double> eta = psi;
      B.mmult(psi, eta);
    }
    psi.mmult(mass, M);
    for (unsigned int j = 0; j < n_kept; ++j)
      for (unsigned int i = 0; i < m; ++i) {
        component.psi(kept[j], i) = psi(j, i);
        if (i == kept[j] || !is_dual || !component.has_function[i]) // the rest biorthogonality makes zero
          component.mass(kept[j], i) = mass(j, i);
      }
  }
}

template <int dim>
void MultiplierSpace<dim>::add_rows(const Face &face, const double t, std::map<Index, Row> &to) const
{
  const Pairing<dim> &pairing = interface.pairing();
  for (const Component &component : face.components)
    for (unsigned int j = 0; j < component.dofs.size(); ++j)
      if (component.has_function[j]) {
        Row &row = to[component.dofs[j]];
        for (unsigned int i = 0; i < component.dofs.size(); ++i)
          if (component.mass(j, i) != 0) {
            row.weights[component.dofs[i]] += component.mass(j, i);
            row.destination_weight += component.mass(j, i);
          }
        row.diagonal += component.mass(j, j);
      }

  for (const unsigned int g : face.groups) {
    std::map<unsigned int, Extension> of_field;
    for (const Component &component : face.components) {
      const auto [entry, is_new] = of_field.try_emplace(component.field);
      if (is_new)
        entry->second = extension(pairing.groups[g], component.field);
      for (unsigned int j = 0; j < component.dofs.size(); ++j)
        if (component.has_function[j]) {
          Row &row = to[component.dofs[j]];
          row.field = component.field;
          row.component = component.component;
          add_source(face, pairing.groups[g], entry->second, component, j, t, row);
        }
    }
  }
}

template <int dim>
typename MultiplierSpace<dim>::Extension
MultiplierSpace<dim>::extension(const typename Pairing<dim>::Group &group, const unsigned int f) const
{
  const Pairing<dim> &pairing = interface.pairing();
  const TiedField &field = interface.fields[f];
  const unsigned int n_points = group.end - group.begin, n_source = field.n_nodes[source],
                     n_destination = field.n_nodes[destination];
  Extension result;
  if (!pairing.is_bridged())
    return result;
  result.shares.assign(n_points, 0.);
  result.of_source.assign(n_points * n_source, 0.);
  result.of_destination.assign(n_points * n_destination, 0.);
  result.of_destination_at_source.assign(n_points * n_source, 0.);
  for (unsigned int p = 0; p < n_points; ++p)
    for (const unsigned int side : {source, destination}) {
      const unsigned int q = group.begin + p, n = field.n_nodes[side];
      if (side == destination && pairing.own_share(q, f) == 0) // add_source() asks nothing of it
        continue;
      const auto &element = interface.sides[side].domain->layout().element(field.first_component[side]);
      double *own = &(side == source ? result.of_source : result.of_destination)[p * n],
             *at_source =
                 &(side == source ? result.of_source : result.of_destination_at_source)[p * n_source];
      const auto bridge = pairing.bridge(side, q, element, field.first_shape[side]);
      const auto *gradients = pairing.gradients(side, q) + field.first_shape[side],
                 *gradients_at_source = pairing.gradients(source, q) + field.first_shape[source];
      const double *trace = pairing.values(source, q) + field.first_shape[source];
      for (unsigned int k = 0; k < n; ++k)
        own[k] += bridge ? bridge->weights[k] : gradients[k] * pairing.offset(q);
      for (unsigned int k = 0; bridge && k < n_source; ++k)
        at_source[k] += gradients_at_source[k] * bridge->along_face - bridge->share * trace[k];
      if (bridge && side == destination)
        result.shares[p] = bridge->share;
    }
  return result;
}

/// The integrals of a group with function @p j of a component: of the source's trace, and of what the gap
/// adds to the destination's.
template <int dim>
void MultiplierSpace<dim>::add_source(const Face &face, const typename Pairing<dim>::Group &group,
                                      const Extension &extension, const Component &component,
                                      const unsigned int j, const double t, Row &row) const
{
  const Pairing<dim> &pairing = interface.pairing();
  const unsigned int n = face.nodes.size(), f = row.field;
  const TiedField &field = interface.fields[f];
  const unsigned int n_source = field.n_nodes[source], n_destination = field.n_nodes[destination],
                     at_source = field.first_shape[source];
  std::vector<double> psi(n, 0.); // at the face's nodes
  for (unsigned int a = 0; a < n; ++a)
    for (unsigned int l = 0; l < component.dofs.size(); ++l)
      psi[a] += component.C(a, l) * component.psi(j, l);

  std::vector<double> moment(n_source, 0.), source_weight(n_source, 0.),
      destination_weight(n_destination, 0.);
  bool is_bridged = false;
  for (unsigned int q = group.begin; q < group.end; ++q) {
    const double *at_destination = pairing.values(destination, q) + field.first_shape[destination];
    double value = 0;
    for (unsigned int a = 0; a < n; ++a)
      value += psi[a] * at_destination[face.nodes[a]];
    value *= pairing.weight(q);
    if (interface.has_prescribed_jump())
      row.constant += value * interface.prescribed_jump(pairing.X(source, q), t, row.component);
    const double *trace = pairing.values(source, q) + at_source;
    for (unsigned int k = 0; k < n_source; ++k)
      moment[k] += value * trace[k];
    if (extension.of_source.empty())
      continue;
    // B = B(X') + (1 - s) of_source + s of_destination, whose B(X') stands for B
    const unsigned int p = q - group.begin;
    const double s = pairing.own_share(q, f), factor = value / (1 + s * extension.shares[p]);
    is_bridged = is_bridged || s > 0;
    for (unsigned int k = 0; k < n_source; ++k) {
      const double of_source = extension.of_source[p * n_source + k],
                   wanted = factor *
                            ((1 - s) * of_source + s * extension.of_destination_at_source[p * n_source + k]);
      moment[k] += wanted;
      source_weight[k] += value * of_source - wanted;
    }
    for (unsigned int k = 0; k < n_destination; ++k)
      destination_weight[k] -= factor * s * extension.of_destination[p * n_destination + k];
  }
  if (is_bridged)
    add_own_gradient(group, f, row.component, destination_weight, source_weight, row);
  const auto &source_dofs = pairing.cells[source][group.cells[source]].dofs;
  const unsigned int first =
      interface.sides[source].domain->layout().first(field.first_component[source] + row.component);
  const bool is_of_both = interface.sides[source].domain == interface.sides[destination].domain;
  for (unsigned int k = 0; k < n_source; ++k)
    if (moment[k] != 0) {
      row.weights[source_dofs[first + k]] -= moment[k];
      row.source_weight -= moment[k];
      if (is_of_both)
        row.of_source[source_dofs[first + k]] -= moment[k];
    }
}

template <int dim>
void MultiplierSpace<dim>::add_own_gradient(const typename Pairing<dim>::Group &group, const unsigned int f,
                                            const unsigned int component,
                                            const std::vector<double> &destination_weight,
                                            const std::vector<double> &source_weight, Row &row) const
{
  const TiedField &field = interface.fields[f];
  const auto dof_of = [&](const unsigned int side, const unsigned int node) {
    return interface.pairing()
        .cells[side][group.cells[side]]
        .dofs[interface.sides[side].domain->layout().index(field.first_component[side] + component, node)];
  };
  for (unsigned int k = 0; k < source_weight.size(); ++k)
    if (source_weight[k] != 0)
      row.source_gain[dof_of(source, k)] -= source_weight[k];
  const Index first = interface.sides[destination].domain->first_dof();
  const auto add = [&row](const Index dof, const double weight) {
    row.weights[dof] += weight;
    row.destination_weight += weight;
    row.own_gradient[dof] += weight;
  };
  for (unsigned int k = 0; k < destination_weight.size(); ++k)
    if (const Index dof = dof_of(destination, k); destination_weight[k] == 0)
      continue;
    else if (hanging.is_constrained(dof - first))
      for (const auto &[master, weight] : *hanging.get_constraint_entries(dof - first))
        add(first + master, weight * destination_weight[k]);
    else
      add(dof, destination_weight[k]);
}

template <int dim>
void MultiplierSpace<dim>::Row::add(const Row &other)
{
  for (const auto part : {&Row::weights, &Row::own_gradient, &Row::source_gain, &Row::of_source})
    for (const auto &[dof, weight] : other.*part)
      (this->*part)[dof] += weight;
  for (const auto sum : {&Row::diagonal, &Row::constant, &Row::source_weight, &Row::destination_weight})
    this->*sum += other.*sum;
  field = other.field;
  component = other.component;
}

template <int dim>
void MultiplierSpace<dim>::make(const TieConstraints &constraints, const MPI_Comm &communicator)
{
  rows.clear();
  are_set = false;
  find_faces();
  const auto keeps = decide(constraints, communicator);
  std::map<Index, Row> mine;
  for (Face &face : faces) {
    for (Component &component : face.components)
      for (const Index dof : component.dofs)
        component.has_function.push_back(!face.groups.empty() && keeps.at(dof));
    make_functions(face);
    add_rows(face, constraints.t, mine);
    for (Component &component : face.components) // which the rows have now
      for (FullMatrix<double> *matrix : {&component.psi, &component.mass}) {
        FullMatrix<double> none;
        matrix->swap(none);
      }
  }

  RankMap<std::map<Index, Row>> rows_of_owners;
  for (auto &[dof, row] : mine)
    rows_of_owners[owner_of.at(dof)][dof] = std::move(row);
  for (const auto &rank_part : exchange(std::move(rows_of_owners), communicator, interface.work()))
    for (const auto &[dof, row] : rank_part.second)
      rows[dof].add(row);
  for (auto &[dof, row] : rows) { // what cancels between the points of a face
    double largest = 0;
    for (const auto &entry : row.weights)
      largest = std::max(largest, std::abs(entry.second));
    for (auto entry = row.weights.begin(); entry != row.weights.end();)
      entry = std::abs(entry->second) <= 1e-14 * largest ? row.weights.erase(entry) : std::next(entry);
  }
}

template <int dim>
std::map<Index, double> MultiplierSpace<dim>::average(const std::vector<std::vector<double>> &value,
                                                      const MPI_Comm &communicator) const
{
  std::map<Index, std::array<double, 2>> sums;
  for (const Face &face : faces)
    for (const Component &component : face.components)
      for (unsigned int j = 0; j < component.dofs.size(); ++j)
        if (component.has_function[j])
          for (const unsigned int g : face.groups)
            for (unsigned int q = interface.pairing().groups[g].begin; q < interface.pairing().groups[g].end;
                 ++q) {
              const double *values = interface.pairing().values(destination, q) + first_shape(face);
              double phi = 0;
              for (unsigned int a = 0; a < face.nodes.size(); ++a)
                phi += component.C(a, j) * values[face.nodes[a]];
              auto &sum = sums[component.dofs[j]];
              sum[0] += interface.pairing().weight(q) * phi * phi * value[component.field][q];
              sum[1] += interface.pairing().weight(q) * phi * phi;
            }
  RankMap<std::map<Index, std::array<double, 2>>> rows_of_owners;
  for (const auto &[dof, sum] : sums)
    rows_of_owners[owner_of.at(dof)][dof] = sum;
  std::map<Index, std::array<double, 2>> totals;
  for (const auto &rank_part : exchange(std::move(rows_of_owners), communicator, interface.work()))
    for (const auto &[dof, sum] : rank_part.second)
      for (const unsigned int i : {0, 1})
        totals[dof][i] += sum[i];
  std::map<Index, double> result;
  for (const auto &[dof, total] : totals)
    result[dof] = total[0] / total[1];
  return result;
}

template <int dim>
void MultiplierSpace<dim>::set_coefficients(const std::map<Index, double> &row_coefficients,
                                            const MPI_Comm &communicator)
{
  RankMap<std::vector<Index>> asked;
  std::set<Index> wanted;
  for (const Face &face : faces)
    for (const Component &component : face.components)
      for (unsigned int j = 0; j < component.dofs.size(); ++j)
        if (component.has_function[j] && wanted.insert(component.dofs[j]).second)
          asked[owner_of.at(component.dofs[j])].push_back(component.dofs[j]);
  RankMap<std::map<Index, double>> answers;
  for (const auto &[rank, dofs] : exchange(std::move(asked), communicator, interface.work()))
    for (const Index dof : dofs)
      answers[rank][dof] = row_coefficients.at(dof);
  std::map<Index, double> known;
  for (auto &rank_part : exchange(std::move(answers), communicator, interface.work()))
    known.merge(rank_part.second);

  for (Face &face : faces)
    for (Component &component : face.components) {
      std::vector<double> function_values(component.dofs.size(), 0.);
      for (unsigned int j = 0; j < component.dofs.size(); ++j)
        if (component.has_function[j])
          function_values[j] = known.at(component.dofs[j]);
      for (const auto &[i, j, c] : component.extrapolation)
        function_values[i] += c * function_values[j];
      component.nodal.assign(face.nodes.size(), 0.);
      for (unsigned int a = 0; a < face.nodes.size(); ++a)
        for (unsigned int j = 0; j < component.dofs.size(); ++j)
          component.nodal[a] += component.C(a, j) * function_values[j];
    }
  are_set = true;
}

template <int dim>
double MultiplierSpace<dim>::value(const unsigned int field, const unsigned int component,
                                   const unsigned int q) const
{
  const auto &layout = interface.sides[destination].domain->layout();
  const unsigned int space = layout.space(interface.fields[field].first_component[destination]);
  const Face &face = faces[face_of_point.at(space)[q]];
  const double *phi = interface.pairing().values(destination, q) + first_shape(face);
  const auto face_component =
      std::find_if(face.components.begin(), face.components.end(),
                   [&](const auto &other) { return other.field == field && other.component == component; });
  double sum = 0;
  for (unsigned int a = 0; a < face.nodes.size(); ++a)
    sum += face_component->nodal[a] * phi[face.nodes[a]];
  return sum;
}

template class MultiplierSpace<2>;
template class MultiplierSpace<3>;

} // namespace dovetail
