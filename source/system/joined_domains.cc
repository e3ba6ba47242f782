// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/joined_domains.h>

#include <map>

namespace dovetail {

template <int dim>
std::vector<unsigned int>
joined_domains(const Model<dim> &model, const std::string &field,
               const std::function<bool(const Interface<dim> &, const TiedField &)> &joins)
{
  std::map<const Domain<dim> *, unsigned int> number;
  for (unsigned int d = 0; d < model.domains.size(); ++d)
    number[model.domains[d].get()] = d;
  std::vector<std::vector<unsigned int>> neighbours(model.domains.size());
  for (const auto &interface : model.interfaces)
    for (const TiedField &tied : interface->fields)
      if (tied.name == field && joins(*interface, tied))
        for (const unsigned int side : {source, destination})
          neighbours[number.at(interface->sides[side].domain)].push_back(
              number.at(interface->sides[1 - side].domain));

  constexpr unsigned int unknown = dealii::numbers::invalid_unsigned_int;
  std::vector<unsigned int> first(model.domains.size(), unknown), open;
  for (unsigned int d = 0; d < model.domains.size(); ++d)
    if (first[d] == unknown) {
      first[d] = d;
      for (open = {d}; !open.empty();) {
        const unsigned int next = open.back();
        open.pop_back();
        for (const unsigned int neighbour : neighbours[next])
          if (first[neighbour] == unknown) {
            first[neighbour] = d;
            open.push_back(neighbour);
          }
      }
    }
  return first;
}

template std::vector<unsigned int>
joined_domains(const Model<2> &, const std::string &,
               const std::function<bool(const Interface<2> &, const TiedField &)> &);
template std::vector<unsigned int>
joined_domains(const Model<3> &, const std::string &,
               const std::function<bool(const Interface<3> &, const TiedField &)> &);

} // namespace dovetail
