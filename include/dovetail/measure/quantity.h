// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What can be shown in ParaView or probed: one catalogue for both.

#pragma once

#include <dovetail/measure/domain_point.h>
#include <dovetail/measure/reactions.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace dovetail {

/// Something that is known at each point of a domain: from its state, from what the laws answer there, or
/// from the mesh. A member of the family is one file that nobody names (doc/how_to/add_a_quantity.md).
template <int dim>
class Quantity
{
public:
  Quantity(const std::string &name, const Domain<dim> &domain) : name(name), domain(domain) {}
  virtual ~Quantity() = default;

  /// What ParaView shows under one name: 1 component: a scalar, dim: a vector, 9: a tensor, row by row.
  struct Array
  {
    std::string name;
    unsigned int n_components;
  };
  /// Override the first one, or the second one if it is several arrays.
  virtual unsigned int n_components() const { return 1; }
  virtual std::vector<Array> arrays() const { return {{name, n_components()}}; }
  unsigned int n_numbers() const; ///< of all arrays

  /// Append the numbers of all arrays at a point. NaN where they are not defined.
  virtual void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const = 0;

  /// A density of what a time step stores: integrals of it use the points that the terms of capacities use,
  /// so that they show what is stored.
  virtual bool is_stored() const { return false; }

  /// Known only at points of the boundary: shown as a surface of its own.
  virtual bool is_of_boundary() const { return false; }

  /// A quantity whose values are forces at nodes is no density, so no probe can show it; it gets the
  /// reactions before each picture. Collective.
  virtual bool is_of_nodes() const { return false; }
  virtual void set_reactions(const Reactions<dim> & /*reactions*/) {}

  /// Asks for velocity(): only bodies with inertia have one.
  virtual bool is_of_motion() const { return false; }
  void set_velocity(const Vector *rates) { velocities = rates; } ///< of all unknowns, ghosted; by reference

protected:
  /// du/dt at a point; zero where nothing is known of it.
  dealii::Tensor<1, dim> velocity(DomainPoint<dim> &point) const;

  const std::string name; ///< in the scene
  const Domain<dim> &domain;

private:
  const Vector *velocities = nullptr;
};

/// All quantities: name -> creator, help, and the field whose law it asks.
template <int dim>
class QuantityCatalogue
{
public:
  using Creator =
      std::function<std::unique_ptr<Quantity<dim>>(const std::string &name, const Domain<dim> &domain)>;
  struct Member
  {
    std::string field; ///< that a domain must have; empty: none
    std::string help;  ///< one sentence with formula and unit
    Creator create;

    std::string unit() const; ///< in SI, as help ends with; empty if there is none
  };

  static bool add(const std::string &name, const Member &member);
  static std::vector<std::string> names(); ///< sorted as in a dictionary
  static std::string help();               ///< of all: "name (help), name (help)"

  /// @throw UserError if @p name is none, with those that are known and the nearest.
  static const Member &find(const std::string &name, const Section &asking, const char *entry);

private:
  static std::map<std::string, Member> &members();
};

/// "solid law" for displacement.
std::string law_of_field(const std::string &field);

/// Register a class template over dim in both dimensions. @p field: whose law it asks, or empty.
template <template <int> class Derived>
bool add_quantity(const std::string &name, const std::string &field, const std::string &help)
{
  return QuantityCatalogue<2>::add(name, {field, help,
                                          [](const std::string &of, const Domain<2> &domain) {
                                            return std::make_unique<Derived<2>>(of, domain);
                                          }}) &&
         QuantityCatalogue<3>::add(name, {field, help, [](const std::string &of, const Domain<3> &domain) {
                                            return std::make_unique<Derived<3>>(of, domain);
                                          }});
}

} // namespace dovetail
