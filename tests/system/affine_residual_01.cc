// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Residuals by products with matrices that stay, against integrals at four states, times and rates: sources,
// fluxes, ambient and prescribed values that depend on t, one of them weakly; reactions, a partition
// coefficient, resistance, springs, thermal strains, inertia beside capacity, lumped capacity, an axis,
// hanging nodes, and each kind of tie. The right-hand side, the forces on constrained unknowns, the flows of
// the cells, what ties transmit, and from the third tangent on the tangent as a sum, relative to the largest.
// Where a coefficient depends on t or on the state, integrals stay.
//
// ranks: 1, 2, 3

#include "scene_model.h"

using namespace test;

namespace {

struct Case
{
  std::string name, material, of_left, of_right, tie;
  std::string top = "", of_mesh = "", material_of_right = "";
  bool has_products = true;
};

template <int dim>
std::string scene(const Case &of)
{
  const std::string cells[] = {dim == 2 ? "3, 2 : 0.5, 0 : 1, 1" : "2, 2, 1 : 0.5, 0, 0 : 1, 1, 1",
                               dim == 2 ? "2, 3 : 1, 0 : 2, 1" : "2, 1, 2 : 1, 0, 0 : 2, 1, 1"};
  return set("Materials", "one, two") + set("Domains", "left, right") + set("Interfaces", "seam") + of.top +
         subsection("Material one", of.material) +
         subsection("Material two", of.material_of_right.empty() ? of.material : of.material_of_right) +
         subsection("Domain left", set("Material", "one") + box(cells[0], of.of_mesh) + of.of_left) +
         subsection("Domain right", set("Material", "two") + box(cells[1]) + of.of_right) +
         subsection("Interface seam", of.tie + set("Source", "left : 1") + set("Destination", "right : 0"));
}

/// Sums over all ranks of what was in and out, and of what ties transmit, as far as there is any.
template <int dim>
std::vector<double> balance(const Model<dim> &model, const Vector &x, BlockSystem<dim> &system)
{
  const NodalForces<dim> forces = system.nodal_forces(x);
  std::vector<double> sums;
  for (const auto &interface : model.interfaces) {
    std::vector<double> influx(2, 0.);
    for (const Transmission &transmission : forces.group_transmissions(*interface))
      for (const unsigned int side : {0, 1})
        influx[side] += (1 + transmission.component + 2 * transmission.field) * transmission.influx[side];
    sums.insert(sums.end(), influx.begin(), influx.end());
  }
  dealii::Utilities::MPI::sum(sums, model.communicator, sums);
  return sums;
}

/// Forces on the constrained unknowns of this rank.
template <int dim>
double difference(const Model<dim> &model, const NodalForces<dim> &a, const NodalForces<dim> &b,
                  const BlockSystem<dim> &system)
{
  double largest = 0, error = 0;
  for (const auto i : model.numbering->owned)
    if (system.is_constrained(i)) {
      largest = std::max(largest, std::abs(a(i)));
      error = std::max(error, std::abs(a(i) - b(i)));
    }
  return dealii::Utilities::MPI::max(error, MPI_COMM_WORLD) /
         std::max(1e-300, dealii::Utilities::MPI::max(largest, MPI_COMM_WORLD));
}

double difference(const Vector &a, const Vector &b)
{
  Vector error = a;
  error -= b;
  return error.linfty_norm() / b.linfty_norm();
}

/// Whether the flows of the cells and the forces of ties add up with the forces on nodes as integrals have
/// it: the sum of the residual of all unknowns of a field is that of its loads, what is stored and
/// transmitted.
template <int dim>
double flows_error(const Model<dim> &model, const NodalForces<dim> &products, const Vector &x, const double t,
                   const Rates &rates)
{
  double error = 0, largest = 0;
  for (unsigned int d = 0; d < model.domains.size(); ++d) {
    const Domain<dim> &domain = *model.domains[d];
    const auto *flows = products.flows_of_cells(d);
    if (flows == nullptr)
      return 1;
    CellTerms<dim> terms(domain);
    terms.set_rates(&rates);
    std::vector<double> sums(2 * domain.n_components(), 0.), found = sums;
    std::vector<dealii::types::global_dof_index> dofs;
    std::vector<double> unknowns(domain.dofs_per_cell()), residual(unknowns.size());
    for (const auto &cell : domain.dof_handler().active_cell_iterators())
      if (cell->is_locally_owned()) {
        domain.cell_dofs(cell, dofs);
        x.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
        for (const unsigned int kind : {0, 1}) {
          if (!(kind == 0 ? terms.assemble_loads(cell, t, unknowns, residual)
                          : terms.assemble_storage(cell, t, unknowns, residual)))
            continue;
          for (unsigned int c = 0; c < domain.n_components(); ++c)
            for (unsigned int a = 0; a < domain.layout().n_nodes(c); ++a)
              sums[2 * c + kind] +=
                  (kind == 0 ? -1 : 1) * domain.layout().unit(c)[a] * residual[domain.layout().index(c, a)];
        }
      }
    for (unsigned int c = 0; c < domain.n_components(); ++c) {
      found[2 * c] = flows->loads.in[c] - flows->loads.out[c];
      found[2 * c + 1] = flows->stored.in[c] - flows->stored.out[c];
    }
    dealii::Utilities::MPI::sum(sums, MPI_COMM_WORLD, sums);
    dealii::Utilities::MPI::sum(found, MPI_COMM_WORLD, found);
    for (unsigned int i = 0; i < sums.size(); ++i) {
      largest = std::max(largest, std::abs(sums[i]));
      error = std::max(error, std::abs(sums[i] - found[i]));
    }
  }
  return error / largest;
}

template <int dim>
void check(const Case &of)
{
  SceneModel<dim> scene_model(scene<dim>(of));
  Model<dim> &model = scene_model.model;
  BlockSystem<dim> products(model);
  products.set_up(0.25);
  double of_residual = 0, of_forces = 0, of_tangent = 0, of_flows = 0, of_ties = 0;
  for (const unsigned int k : {0, 1, 2, 3, 4}) {
    const double t = 0.25 * (1 + k);
    Vector x = products.owned_vector();
    Rates rates;
    rates.by_value = 3 + k;
    rates.rest = x;
    if (model.order_in_time() > 1) {
      rates.second_by_value = 20 + k;
      rates.second_rest = x;
    }
    for (const auto i : model.numbering->owned) {
      x(i) = noise(i + 100 * k);
      rates.rest(i) = noise(i + 100 * k + 37);
      if (model.order_in_time() > 1)
        rates.second_rest(i) = noise(i + 100 * k + 53);
    }
    x.compress(dealii::VectorOperation::insert);
    rates.rest.compress(dealii::VectorOperation::insert);
    if (model.order_in_time() > 1)
      rates.second_rest.compress(dealii::VectorOperation::insert);
    products.set_rates(rates);
    products.begin_step(t, x);
    products.constrain(x);
    products.assemble(x, true);
    products.assemble(x, false);

    BlockSystem<dim> integrals(model);
    integrals.set_up(t);
    integrals.set_rates(rates);
    integrals.begin_step(t, x);
    const NodalForces<dim> expected = integrals.nodal_forces(x);
    const std::vector<double> transmitted = balance(model, x, integrals);
    integrals.assemble(x, true);
    of_residual =
        std::max(of_residual, difference(products.negative_residual(), integrals.negative_residual()));
    Vector v = x, Kv = x, expected_Kv = x;
    for (const auto i : model.numbering->owned)
      v(i) = products.is_constrained(i) ? 0. : noise(3 * i + k);
    v.compress(dealii::VectorOperation::insert);
    products.tangent().vmult(Kv, v);
    integrals.tangent().vmult(expected_Kv, v);
    of_tangent = std::max(of_tangent, difference(Kv, expected_Kv));
    const NodalForces<dim> found = products.nodal_forces(x);
    of_forces = std::max(of_forces, difference(model, expected, found, products));
    Rates ghosted_rates = rates;
    ghosted_rates.rest = products.ghosted(rates.rest);
    if (model.order_in_time() > 1)
      ghosted_rates.second_rest = products.ghosted(rates.second_rest);
    if (of.has_products)
      of_flows = std::max(of_flows, flows_error(model, found, products.ghosted(x), t, ghosted_rates));
    const std::vector<double> found_transmitted = balance(model, x, products);
    for (unsigned int i = 0; i < transmitted.size(); ++i)
      of_ties = std::max(of_ties, std::abs(transmitted[i] - found_transmitted[i]) /
                                      std::max(1e-3, std::abs(transmitted[i])));
  }
  report(of.name + ", residual", of_residual, 1e-12);
  report(of.name + ", tangent", of_tangent, 1e-12);
  report(of.name + ", forces on nodes", of_forces, 1e-12);
  report(of.name + ", flows", of_flows, 1e-11);
  report(of.name + ", ties", of_ties, 1e-10);
  const auto counts = products.assemblies();
  print(of.name + ", tangents and residuals by integrals, by products:",
        {double(counts.tangents), double(counts.residuals_alone), double(counts.tangents_by_sums),
         double(counts.residuals_by_products)});
}

std::string condition(const std::string &name, const std::string &entries)
{
  return set("Boundary conditions", name) + subsection("Boundary condition " + name, entries);
}

std::string value(const std::string &field, const std::string &expression, const std::string &more = "")
{
  return condition("end", set("Type", "value") + set("Field", field) + set("Boundary ids", "0") +
                              set("Expression", expression) + more);
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string transient = subsection("Steps", set("Kind", "transient")),
                    lumped = subsection("Steps", set("Kind", "transient") + set("Lumped capacity", "true"));
  const std::string nitsche = set("Type", "Nitsche"), dual = set("Type", "mortar"),
                    standard = set("Type", "mortar") + set("Multiplier space", "standard"),
                    pointwise = set("Type", "pointwise"),
                    resistance = set("Type", "contact resistance") + set("Conductance", "2 + y");
  const auto conducts = [](const std::string &conductivity, const std::string &more = "") {
    return subsection("Heat", set("Type", "Fourier") + set("Conductivity", conductivity) +
                                  set("Density", "2") + set("Heat capacity", "1.5 + x") + more);
  };
  const std::string heat = conducts("2 + x", set("Heat source", "5*x"));
  const std::string air = condition("air", set("Type", "convection") + set("Field", "temperature") +
                                               set("Boundary ids", "1") + set("Coefficient", "3 + y") +
                                               set("Ambient", "20*t")),
                    flux = condition("flux", set("Type", "flux") + set("Field", "temperature") +
                                                 set("Boundary ids", "1") + set("Expression", "4*t*y")),
                    source = subsection("Source", set("temperature", "7*t*x + 1")), two = set("Degree", "2");
  check<2>({"heat", heat, value("temperature", "1 + t*y") + source, air + two, nitsche, transient});
  check<3>({"heat in 3D", heat, value("temperature", "1") + two, flux, nitsche, transient});
  check<2>({"weak value", heat, value("temperature", "1 + t*y", set("Method", "Nitsche")), flux + source,
            nitsche + set("Theta", "0"), transient});
  check<2>(
      {"lumped", heat, value("temperature", "2"), air, dual, lumped, set("Refine boxes", "0.8; 0 : 1; 0.4")});
  check<2>({"multipliers", heat, value("temperature", "2*t"), air, standard, transient});
  check<2>({"pointwise", heat, value("temperature", "2*t"), air, pointwise, transient});
  check<2>({"resistance", heat, value("temperature", "2*t"), air, resistance, transient});
  check<2>({"around an axis", heat, value("temperature", "2"), air, nitsche,
            set("Geometry", "axisymmetric") + transient});
  const std::string species =
      set("Species", "a, b") +
      subsection("Species a", set("Type", "Fick") + set("Diffusivity", "2") + set("Reaction", "-a")) +
      subsection("Species b", set("Type", "Fick") + set("Diffusivity", "1") + set("Reaction", "a - 3*b + x"));
  const std::string partition =
      set("Species", "a") +
      subsection("Species a", set("Type", "Fick") + set("Diffusivity", "2") + set("Reaction", "1 - a"));
  check<2>({"species", species, value("a", "t"), "", nitsche, transient});
  check<2>(
      {"partition", partition, value("a", "t"), "", nitsche + set("Partition coefficient", "3"), transient});
  const std::string elastic =
      subsection("Solid", set("Type", "linear elastic") + set("Young modulus", "3") +
                              set("Poisson ratio", "0.3") + set("Density", "2") +
                              set("Expansion coefficient", "0.1") + set("Reference temperature", "0.5"));
  const std::string waves = subsection(
      "Steps", set("Kind", "transient") + set("Scheme", "generalised alpha") + set("Inertia", "true"));
  const std::string spring =
      condition("spring", set("Type", "spring") + set("Boundary ids", "1") + set("Coefficient", "3; 2"));
  check<2>({"waves and heat", elastic + heat, value("displacement", "t; 0") + set("Acceleration", "0; -t"),
            spring, nitsche, waves});
  check<2>({"heat beside a solid", elastic + heat, value("displacement", "t; 0"), spring, dual, transient});
  check<2>({"conductivity in t", conducts("1 + t"), value("temperature", "2*t"), air, nitsche, transient, "",
            "", false});
  check<2>({"conductivity in T", conducts("1 + T^2"), value("temperature", "2*t"), air, nitsche, transient,
            "", "", false});
  check<2>({"jump in t", heat, value("temperature", "2*t"), air, nitsche + set("Jump", "t"), transient, "",
            "", false});
}
