// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/point_products.h>
#include <dovetail/interface/interface.h>
#include <dovetail/interface/leading_unknowns.h>

#include <deal.II/fe/fe_q.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dovetail {

namespace {

constexpr unsigned int anywhere = dealii::numbers::invalid_unsigned_int;

/// Distance of a node from a face of the unit cell.
template <int dim>
double depth(const dealii::Point<dim> &node, const unsigned int face)
{
  return std::abs(node[face / 2] - face % 2);
}

struct Follower
{
  unsigned int leader; ///< node
  double factor;
};

/// Of each node of an element.
template <int dim>
std::vector<Follower> find_leaders(const dealii::FiniteElement<dim> &element, const unsigned int face)
{
  const double on_face = 1e-10;
  const auto &points = element.get_unit_support_points();
  const unsigned int normal = face / 2;
  std::vector<Follower> leaders;
  for (unsigned int a = 0; a < points.size(); ++a) {
    dealii::Point<dim> foot = points[a];
    foot[normal] = face % 2;
    leaders.push_back({a, 1.});
    if (depth(points[a], face) <= on_face)
      continue;
    for (unsigned int b = 0; b < points.size(); ++b) {
      dealii::Tensor<1, dim> across = points[b] - points[a];
      across[normal] = 0;
      if (across.norm() <= on_face && depth(points[b], face) > on_face &&
          depth(points[b], face) < depth(points[leaders[a].leader], face))
        leaders[a].leader = b;
    }
    if (leaders[a].leader != a)
      leaders[a].factor =
          element.shape_grad(a, foot)[normal] / element.shape_grad(leaders[a].leader, foot)[normal];
  }
  return leaders;
}

/// Whether nodes follow at a face: the element is a product of Lagrange polynomials above degree one.
template <int dim>
bool has_followers(const dealii::FiniteElement<dim> &element)
{
  return dynamic_cast<const dealii::FE_Q<dim> *>(&element) != nullptr && element.degree > 1;
}

} // namespace

template <int dim>
LeadingUnknowns find_leading_unknowns(const Interface<dim> &interface,
                                      const std::array<unsigned int, 2> &faces)
{
  LeadingUnknowns result;
  for (const unsigned int side : {0u, 1u}) {
    const auto &layout = interface.sides[side].domain->layout();
    for (const unsigned int c : interface.components[side]) {
      std::vector<Follower> leaders;
      if (faces[side] != anywhere && has_followers(layout.element(c)))
        leaders = find_leaders(layout.element(c), faces[side]);
      else
        for (unsigned int a = 0; a < layout.n_nodes(c); ++a)
          leaders.push_back({a, 1.});
      std::vector<unsigned int> nodes, number(leaders.size());
      const unsigned int first = result.size();
      for (unsigned int a = 0; a < leaders.size(); ++a)
        if (leaders[a].leader == a) {
          number[a] = first + nodes.size();
          nodes.push_back(a);
        }
      for (const Follower &follower : leaders) {
        result.leader.push_back(number[follower.leader]);
        result.factor.push_back(follower.factor);
      }
      result.first[side].push_back(first);
      result.n_of_side[side] += nodes.size();
      result.nodes[side].push_back(std::move(nodes));
    }
  }
  return result;
}

template <int dim>
unsigned int face_of_group(const Interface<dim> &interface, const unsigned int side, const unsigned int begin,
                           const unsigned int end)
{
  const auto &layout = interface.sides[side].domain->layout();
  for (const unsigned int c : interface.components[side]) {
    if (!has_followers(layout.element(c)))
      continue;
    const auto &nodes = layout.element(c).get_unit_support_points();
    for (unsigned int face = 0; face < 2 * dim; ++face) {
      bool is_there = true;
      for (unsigned int q = begin; is_there && q < end; ++q) {
        const double *values = interface.pairing().values(side, q) + layout.first_shape(c);
        for (unsigned int a = 0; is_there && a < nodes.size(); ++a)
          is_there = std::abs(values[a]) <= Interface<dim>::least_in_jump || depth(nodes[a], face) < 1e-10;
      }
      if (is_there)
        return face;
    }
    break;
  }
  return anywhere;
}

void LeadingUnknowns::expand(const std::vector<double> &of_leaders, std::vector<double> &of_all) const
{
  of_all.resize(leader.size());
  for (unsigned int i = 0; i < leader.size(); ++i)
    of_all[i] = factor[i] * of_leaders[leader[i]];
}

void LeadingUnknowns::expand(const dealii::FullMatrix<double> &of_leaders,
                             dealii::FullMatrix<double> &of_all) const
{
  const unsigned int n = leader.size();
  if (of_all.m() != n || of_all.n() != n)
    of_all.reinit(n, n, true);
  for (unsigned int i = 0; i < n; ++i) {
    const double *from = &of_leaders(leader[i], 0);
    double *to = &of_all(i, 0);
    for (unsigned int j = 0; j < n; ++j)
      to[j] = factor[i] * factor[j] * from[leader[j]];
  }
}

std::vector<double> LeadingUnknowns::sizes_of_products(const dealii::FullMatrix<double> &of_leaders,
                                                       const std::vector<double> &x) const
{
  std::vector<double> largest(size(), 0.), sums(size(), 0.), result(leader.size());
  for (unsigned int i = 0; i < leader.size(); ++i)
    largest[leader[i]] += std::abs(factor[i] * x[i]);
  add_up_sizes(size(), &of_leaders(0, 0), largest.data(), sums.data());
  for (unsigned int i = 0; i < leader.size(); ++i)
    result[i] = std::abs(factor[i]) * sums[leader[i]];
  return result;
}

template LeadingUnknowns find_leading_unknowns(const Interface<2> &, const std::array<unsigned int, 2> &);
template LeadingUnknowns find_leading_unknowns(const Interface<3> &, const std::array<unsigned int, 2> &);
template unsigned int face_of_group(const Interface<2> &, unsigned int, unsigned int, unsigned int);
template unsigned int face_of_group(const Interface<3> &, unsigned int, unsigned int, unsigned int);

} // namespace dovetail
