// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/joined_fields.h>

#include <map>

namespace dovetail {

template <int dim>
std::vector<std::vector<unsigned int>>
joined_fields(const Model<dim> &model,
              const std::function<bool(const Interface<dim> &, const TiedField &)> &joins)
{
  std::map<const Domain<dim> *, unsigned int> number;
  std::vector<unsigned int> begin = {0};
  for (const auto &domain : model.domains) {
    number[domain.get()] = begin.size() - 1;
    begin.push_back(begin.back() + domain->fields().size());
  }
  std::vector<std::vector<unsigned int>> neighbours(begin.back());
  for (const auto &interface : model.interfaces)
    for (const TiedField &tied : interface->fields)
      if (joins(*interface, tied)) {
        std::array<unsigned int, 2> ends;
        for (const unsigned int side : {source, destination})
          ends[side] = begin[number.at(interface->sides[side].domain)] + tied.field[side];
        for (const unsigned int side : {source, destination})
          neighbours[ends[side]].push_back(ends[1 - side]);
      }

  constexpr unsigned int unknown = dealii::numbers::invalid_unsigned_int;
  std::vector<unsigned int> group(begin.back(), unknown), open;
  for (unsigned int i = 0; i < group.size(); ++i)
    if (group[i] == unknown) {
      group[i] = i;
      for (open = {i}; !open.empty();) {
        const unsigned int next = open.back();
        open.pop_back();
        for (const unsigned int neighbour : neighbours[next])
          if (group[neighbour] == unknown) {
            group[neighbour] = i;
            open.push_back(neighbour);
          }
      }
    }
  std::vector<std::vector<unsigned int>> result;
  for (unsigned int d = 0; d + 1 < begin.size(); ++d)
    result.emplace_back(group.begin() + begin[d], group.begin() + begin[d + 1]);
  return result;
}

template std::vector<std::vector<unsigned int>>
joined_fields(const Model<2> &, const std::function<bool(const Interface<2> &, const TiedField &)> &);
template std::vector<std::vector<unsigned int>>
joined_fields(const Model<3> &, const std::function<bool(const Interface<3> &, const TiedField &)> &);

} // namespace dovetail
