// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/free_motions.h>

#include <dovetail/system/eigenvectors.h>
#include <dovetail/system/joined_fields.h>

#include <deal.II/base/array_view.h>
#include <deal.II/base/mpi.h>

#include <algorithm>
#include <map>
#include <utility>

namespace dovetail {

namespace {

const double share_of_free_motion = 1e-9; ///< of the largest eigenvalue; less is rounding

/// Bodies that move as one in a field; its name may be another one in each.
template <int dim>
struct JoinedBodies
{
  std::vector<std::pair<const Domain<dim> *, const Field *>> bodies;
  dealii::Point<dim> centre;
  double length = 0;
  bool is_vector = false, is_around_axis = false;

  unsigned int n_modes() const { return !is_vector || is_around_axis ? 1 : dim * (dim + 1) / 2; }

  /// The motion k at a point; of a scalar in the first component.
  dealii::Tensor<1, dim> mode(const unsigned int k, const dealii::Point<dim> &X) const
  {
    dealii::Tensor<1, dim> z;
    if (!is_vector)
      z[0] = 1;
    else if (is_around_axis)
      z[1] = 1;
    else if (k < dim)
      z[k] = 1;
    else {
      const dealii::Tensor<1, dim> r = 2 / length * (X - centre);
      const unsigned int axis = k - dim, one = dim == 2 ? 0 : (axis + 1) % 3,
                         other = dim == 2 ? 1 : (axis + 2) % 3;
      z[one] = -r[other];
      z[other] = r[one];
    }
    return z;
  }
};

/// P as it grows.
template <int dim>
class SeenMotions
{
public:
  explicit SeenMotions(const JoinedBodies<dim> &group) : group(group), P(group.n_modes(), group.n_modes()) {}

  /// @p direction of what is resisted
  void add(const dealii::Point<dim> &X, const dealii::Tensor<1, dim> &direction)
  {
    for (unsigned int k = 0; k < P.m(); ++k)
      for (unsigned int l = 0; l < P.m(); ++l)
        P(k, l) += (group.mode(k, X) * direction) * (group.mode(l, X) * direction);
  }
  void add_component(const dealii::Point<dim> &X, const unsigned int component)
  {
    dealii::Tensor<1, dim> direction;
    direction[component] = 1;
    add(X, direction);
  }

  dealii::FullMatrix<double> sum_of_ranks(const MPI_Comm &communicator)
  {
    const unsigned int size = P.m() * P.m();
    dealii::Utilities::MPI::sum(dealii::ArrayView<const double>(&P(0, 0), size), communicator,
                                dealii::ArrayView<double>(&P(0, 0), size));
    return P;
  }

private:
  const JoinedBodies<dim> &group;
  dealii::FullMatrix<double> P;
};

template <int dim>
void add_condition_to(SeenMotions<dim> &seen, const Domain<dim> &body, const Condition<dim> &condition)
{
  std::vector<unsigned int> components;
  for (unsigned int c = 0; c < condition.field.n_components; ++c)
    if (!condition.constrains_normal() && condition.removes_constant(c))
      components.push_back(c);
  if (condition.point()) {
    for (const unsigned int c : condition.prescribed_components())
      seen.add_component(*condition.point(), c); // by each rank alike
    return;
  }
  for (const auto &face : body.boundary_faces())
    if (face.cell->is_locally_owned() && condition.boundary_ids.count(face.id) > 0) {
      const auto shape = face.cell->face(face.number);
      for (const unsigned int v : shape->vertex_indices()) {
        for (const unsigned int c : components)
          seen.add_component(shape->vertex(v), c);
        if (condition.constrains_normal())
          seen.add(shape->vertex(v), body.plane_normal(face));
      }
    }
}

/// In words what P does not see, or nothing.
template <int dim>
std::string unseen(const JoinedBodies<dim> &group, const dealii::FullMatrix<double> &P)
{
  const dealii::Vector<double> values = eigenvectors(P).first;
  const double least = share_of_free_motion * std::max(values.linfty_norm(), 1e-300);
  unsigned int n_free =
      std::count_if(values.begin(), values.end(), [&](const double v) { return v <= least; });
  if (n_free == 0)
    return {};
  if (!group.is_vector)
    return "a constant";
  if (group.is_around_axis)
    return "a translation along y";
  std::vector<std::string> axes;
  for (unsigned int c = 0; c < dim; ++c)
    if (P(c, c) <= least)
      axes.emplace_back(1, "xyz"[c]);
  std::string words = axes.empty() ? "" : "a translation along " + comma_separated(axes);
  n_free -= std::min<unsigned int>(n_free, axes.size());
  if (n_free > 0)
    words +=
        (words.empty() ? "" : " and ") + std::to_string(n_free) + (n_free == 1 ? " rotation" : " rotations");
  return words;
}

/// The bodies that ties hold together in a field; it has this name in the first of them.
template <int dim>
std::vector<JoinedBodies<dim>> joined_bodies(const Model<dim> &model, const std::string &field,
                                             const std::optional<double> t)
{
  const auto joined = joined_fields<dim>(model, [&](const auto &interface, const TiedField &tied) {
    return (!t || interface.is_active(*t)) && interface.tie().holds(tied);
  });
  std::map<unsigned int, JoinedBodies<dim>> groups;
  for (unsigned int d = 0; d < model.domains.size(); ++d)
    for (unsigned int f = 0; f < joined[d].size(); ++f) {
      JoinedBodies<dim> &group = groups[joined[d][f]];
      const Domain<dim> &body = *model.domains[d];
      const Field &own = body.fields()[f];
      if (group.bodies.empty())
        group.centre = body.centre();
      group.bodies.emplace_back(&body, &own);
      group.length = std::max(group.length, 2 * body.centre().distance(group.centre) + body.typical_length());
      group.is_vector = own.n_components > 1;
      group.is_around_axis = body.measure.has_hoop_strain(own);
    }
  std::vector<JoinedBodies<dim>> result;
  for (const auto &[number, group] : groups)
    if (group.bodies[0].second->name == field)
      result.push_back(group);
  return result;
}

} // namespace

std::string FreeMotion::in_words() const
{
  return "the " + field + " of " + comma_separated(bodies) + " against " + kind;
}

template <int dim>
std::vector<FreeMotion> find_free_motions(const Model<dim> &model, const std::optional<double> t)
{
  std::vector<FreeMotion> motions;
  for (const auto &fields : model.field_groups())
    for (const std::string &field : fields)
      for (const JoinedBodies<dim> &group : joined_bodies(model, field, t)) {
        const auto is_held_otherwise = [](const auto &member) {
          const auto &[body, own] = member;
          const bool may_react =
              own->n_components == 1 && body->material.has_load(own - body->fields().data());
          return !own->is_continuous || own->is_multiplier || may_react ||
                 body->material.order_in_time(own->first_component) > 0;
        };
        if (std::any_of(group.bodies.begin(), group.bodies.end(), is_held_otherwise))
          continue;
        SeenMotions<dim> seen(group);
        for (const auto &[body, own] : group.bodies)
          for (const auto &condition : body->conditions())
            if (condition->field.name == own->name && (!t || condition->is_active(*t)))
              add_condition_to(seen, *body, *condition);
        const std::string kind = unseen(group, seen.sum_of_ranks(model.communicator));
        if (kind.empty())
          continue;
        motions.push_back({field, {}, kind});
        for (const auto &member : group.bodies)
          motions.back().bodies.push_back(member.first->name);
      }
  return motions;
}

template std::vector<FreeMotion> find_free_motions(const Model<2> &, std::optional<double>);
template std::vector<FreeMotion> find_free_motions(const Model<3> &, std::optional<double>);

} // namespace dovetail
