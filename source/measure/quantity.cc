// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/quantity.h>
#include <dovetail/scene/catalogue.h>

#include <algorithm>
#include <cctype>

namespace dovetail {

std::string law_of_field(const std::string &field)
{
  return field == "displacement" ? "solid law" : field == "temperature" ? "heat law" : "law for " + field;
}

template <int dim>
unsigned int Quantity<dim>::n_numbers() const
{
  unsigned int sum = 0;
  for (const Array &array : arrays())
    sum += array.n_components;
  return sum;
}

template <int dim>
dealii::Tensor<1, dim> Quantity<dim>::velocity(DomainPoint<dim> &point) const
{
  dealii::Tensor<1, dim> v;
  const CellLayout<dim> &layout = domain.layout();
  const Field *field = domain.material.find_field("displacement");
  for (unsigned int i = 0; velocities != nullptr && i < dim; ++i) {
    const unsigned int c = field->first_component + i;
    for (unsigned int a = 0; a < layout.n_nodes(c); ++a)
      v[i] +=
          point.shape_values()[layout.first_shape(c) + a] * (*velocities)(point.dofs()[layout.index(c, a)]);
  }
  return v;
}

template <int dim>
std::string QuantityCatalogue<dim>::Member::unit() const
{
  const auto bracket = help.rfind('[');
  return bracket == std::string::npos ? "" : help.substr(bracket + 1, help.rfind(']') - bracket - 1);
}

template <int dim>
std::map<std::string, typename QuantityCatalogue<dim>::Member> &QuantityCatalogue<dim>::members()
{
  static std::map<std::string, Member> all;
  return all;
}

template <int dim>
bool QuantityCatalogue<dim>::add(const std::string &name, const Member &member)
{
  const bool is_new = members().emplace(name, member).second;
  if (!is_new)
    names_registered_twice().push_back(name);
  return is_new;
}

template <int dim>
std::vector<std::string> QuantityCatalogue<dim>::names()
{
  std::vector<std::string> result;
  for (const auto &[name, member] : members())
    result.push_back(name);
  const auto comes_before = [](const std::string &a, const std::string &b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(),
                                        [](const unsigned char left, const unsigned char right) {
                                          return std::tolower(left) < std::tolower(right);
                                        });
  };
  std::stable_sort(result.begin(), result.end(), comes_before);
  return result;
}

template <int dim>
std::string QuantityCatalogue<dim>::help()
{
  std::string result;
  for (const std::string &name : names())
    result += (result.empty() ? "" : ", ") + name + " (" + members().at(name).help + ")";
  return result;
}

template <int dim>
const typename QuantityCatalogue<dim>::Member &
QuantityCatalogue<dim>::find(const std::string &name, const Section &asking, const char *entry)
{
  const auto found = members().find(name);
  if (found == members().end())
    asking.fail(entry, "has '" + name + "', but known are " + comma_separated(names()) + ". " +
                           did_you_mean(name, names()));
  return found->second;
}

template class Quantity<2>;
template class Quantity<3>;
template class QuantityCatalogue<2>;
template class QuantityCatalogue<3>;

} // namespace dovetail
