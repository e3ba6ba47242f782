// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Nitsche's tie, contact resistance and joints that break, group by group: the tangent against central
// differences of the residual (relative error at most 1e-7) at random states with a jump, for every law,
// theta, choice of weights and sides, gap extension and joint, over an interface with a gap. Entries that
// Interface::couples excludes vanish. What one side gets the other gives: for constant test functions of a
// component on both sides the residual vanishes. For theta = 1 the tangent of elastic solids and of k(x) is
// symmetric to 1e-12, except if the gap extension is not, or the conductance depends on the temperature.
// theta = 0 varies no flux but by pressures, linear laws are varied once only. Around an axis all this holds
// but for the radial balance, of which the hoop stress takes a part. Pressures of mixed formulations are
// varied likewise.

#include "../system/scene_model.h"

#include <array>

using namespace test;

struct Choice
{
  std::string theta, weights, integrate_on, extension;
  std::string multiplier = "automatic";
};

struct Laws
{
  std::string name, source, destination; ///< entries of the two materials
  double size;                           ///< of the displacement gradients
  bool is_symmetric;                     ///< for theta = 1
  std::string conductance = ""; ///< and stiffness, of a joint between the two; none if both are empty
  std::string stiffness = "";
  bool is_around_axis = false;
  std::string joint = ""; ///< entries of its law

  Laws around_axis() const
  {
    return {name + ", axisymmetric",
            source,
            destination,
            size,
            is_symmetric,
            conductance,
            stiffness,
            true,
            joint};
  }
  Laws with_law(const std::string &law_name, const std::string &law, const bool joint_is_symmetric) const
  {
    Laws result = with_joint("", joint_is_symmetric ? "2" : "2; 3");
    result.name = name + ", " + law_name;
    result.is_symmetric = is_symmetric && joint_is_symmetric;
    result.joint = law;
    return result;
  }
  Laws with_joint(const std::string &of_heat, const std::string &of_solid) const
  {
    return {
        name + ", joint", source,  destination, size, is_symmetric && of_heat.find('T') == std::string::npos,
        of_heat,          of_solid};
  }
  /// Through which heat flows by how the solids meet.
  Laws with_contact(const std::string &of_heat) const
  {
    Laws result = with_joint(of_heat, "0.7; 3");
    result.name = name + ", contact";
    result.is_symmetric = false;
    return result;
  }
};

std::string solid(const std::string &type, const std::string &more = "")
{
  return subsection("Solid",
                    set("Type", type) + set("Young modulus", "2") + set("Poisson ratio", "0.3") + more);
}

std::string heat(const std::string &conductivity)
{
  return subsection("Heat", set("Type", "Fourier") + set("Conductivity", conductivity));
}

template <int dim>
std::string scene(const Laws &laws, const Choice &choice, const unsigned int degree)
{
  const bool has_solid = laws.source.find("Solid") != std::string::npos,
             has_heat = laws.source.find("Heat") != std::string::npos;
  const std::string clamp =
      subsection("Boundary condition clamp", set("Type", "value") + set("Field", "displacement") +
                                                 set("Boundary ids", "0") +
                                                 set("Expression", dim == 2 ? "0; 0" : "0; 0; 0"));
  const std::string cold =
      subsection("Boundary condition cold", set("Type", "value") + set("Field", "temperature") +
                                                set("Boundary ids", "0") + set("Expression", "3"));
  std::string conditions = has_solid ? "clamp" : "";
  if (has_heat)
    conditions += has_solid ? ", cold" : "cold";
  const std::string given_degree = set("Degree", std::to_string(degree));
  return (laws.is_around_axis ? set("Geometry", "axisymmetric") : "") + set("Materials", "first, second") +
         set("Domains", "left, right") + set("Interfaces", "seam") +
         subsection("Material first", laws.source) + subsection("Material second", laws.destination) +
         subsection("Domain left", set("Material", "first") + set("Boundary conditions", conditions) +
                                       given_degree + (has_solid ? clamp : "") + (has_heat ? cold : "") +
                                       box(dim == 2 ? "1, 2 : 0, 0 : 1, 1" : "1, 1, 2 : 0, 0, 0 : 1, 1, 1")) +
         subsection("Domain right",
                    set("Material", "second") + given_degree +
                        box(dim == 2 ? "1, 3 : 1.02, 0 : 2, 1" : "1, 2, 1 : 1.02, 0, 0 : 2, 1, 1")) +
         subsection("Interface seam",
                    set("Type", laws.conductance + laws.stiffness == "" ? "Nitsche" : "contact resistance") +
                        (laws.conductance == "" ? "" : set("Conductance", laws.conductance)) +
                        (laws.stiffness == "" ? "" : set("Joint stiffness", laws.stiffness)) + laws.joint +
                        set("Source", "left : 1") + set("Destination", "right : 0") +
                        set("Theta", choice.theta) + set("Weights", choice.weights) +
                        set("Multiplier", choice.multiplier) + set("Integrate on", choice.integrate_on) +
                        set("Gap extension", choice.extension) + set("Quadrature", "mapped points") +
                        set("Points per face", "2"));
}

/// Largest relative errors: of the tangent, of its symmetry, of what must not couple, of the balance.
struct Errors
{
  double tangent = 0, symmetry = 0, coupling = 0, balance = 0;
  unsigned long variations = 0, curvatures = 0; ///< that should not have been evaluated
};

template <int dim>
Errors check(const Laws &laws, const Choice &choice, const unsigned int degree, const unsigned int n_groups)
{
  SceneModel<dim> scene_model(scene<dim>(laws, choice, degree));
  Model<dim> &model = scene_model.model;
  const Interface<dim> &interface = *model.interfaces[0];
  Tie<dim> &tie = interface.tie();
  PointTerms<dim> &terms = *tie.parts().point_terms;

  std::vector<double> x(model.numbering->n_dofs());
  for (unsigned int i = 0; i < x.size(); ++i)
    x[i] = model.numbering->blocks()[model.numbering->block_of(i)].field == "temperature"
               ? 3 + noise(i)
               : laws.size * noise(i);
  tie.begin_step(
      interface, 1.,
      [&](const std::vector<dealii::types::global_dof_index> &dofs, std::vector<double> &values) {
        values.clear();
        for (const auto dof : dofs)
          values.push_back(x[dof]);
      },
      MPI_COMM_WORLD);

  Errors errors;
  const auto &groups = interface.pairing().groups;
  for (unsigned int g = 0; g < std::min<std::size_t>(n_groups, groups.size()); ++g) {
    const auto &group = groups[g];
    std::vector<double> unknowns = of_group(interface, group, x);
    const unsigned int n = unknowns.size();
    std::vector<double> residual(n, 0.);
    dealii::FullMatrix<double> tangent(n, n), difference(n, n);
    bool is_defined = terms.assemble(interface, group, 1., unknowns, residual, &tangent);
    const double h = laws.joint == "" ? 1e-5 : 1e-6; // their openings are small
    for (unsigned int j = 0; j < n; ++j) {
      std::vector<double> plus(n, 0.), minus(n, 0.);
      const double center = unknowns[j];
      unknowns[j] = center + h;
      is_defined = terms.assemble(interface, group, 1., unknowns, plus, nullptr) && is_defined;
      unknowns[j] = center - h;
      is_defined = terms.assemble(interface, group, 1., unknowns, minus, nullptr) && is_defined;
      unknowns[j] = center;
      for (unsigned int i = 0; i < n; ++i)
        difference(i, j) = (plus[i] - minus[i]) / (2 * h);
    }
    const double norm = tangent.frobenius_norm();
    dealii::FullMatrix<double> antisymmetric = tangent;
    antisymmetric.Tadd(-1, tangent);
    difference.add(-1, tangent);
    errors.tangent = std::max(errors.tangent, is_defined ? difference.frobenius_norm() / norm : 1e300);
    errors.symmetry = std::max(errors.symmetry, antisymmetric.frobenius_norm() / norm);

    std::vector<unsigned int> component;
    for (const unsigned int side : {source, destination})
      for (unsigned int k = 0; k < interface.components[side].size(); ++k)
        component.insert(component.end(),
                         interface.sides[side].domain->layout().n_nodes(interface.components[side][k]),
                         k + (side == source ? 0 : interface.components[source].size()));
    // both sides have the same fields here: component k of the source is component k of the destination
    std::vector<double> sums(interface.components[source].size(), 0.);
    double size = 0;
    for (unsigned int i = 0; i < n; ++i) {
      sums[component[i] % sums.size()] += residual[i];
      size = std::max(size, std::abs(residual[i]));
    }
    if (laws.is_around_axis && laws.size > 0)
      sums[0] = 0;
    for (unsigned int k = 0; k < sums.size(); ++k)
      for (const Field &field : interface.sides[source].domain->fields())
        if (field.is_multiplier && field.first_component == interface.components[source][k])
          sums[k] = 0; // its equation is no balance
    for (const double sum : sums)
      errors.balance = std::max(errors.balance, std::abs(sum) / size);
    for (unsigned int i = 0; i < n; ++i)
      for (unsigned int j = 0; j < n; ++j)
        if (!interface.couples(component[i], component[j]))
          errors.coupling = std::max(errors.coupling, std::abs(tangent(i, j)));
  }
  const auto variations = terms.flux_variations();
  const bool varies_nothing = choice.theta == "0" && laws.source.find("mixed") == std::string::npos;
  if (varies_nothing)
    errors.variations = variations.first;
  else if (variations.first == 0)
    errors.variations = 1;
  if (varies_nothing || interface.is_linear())
    errors.curvatures = variations.second;
  return errors;
}

template <int dim>
void test_laws(const std::vector<Laws> &all_laws, const unsigned int degree, const unsigned int n_groups)
{
  const std::array<std::string, 4> thetas = {{"1", "0", "-1", "0.3"}};
  const std::array<std::string, 5> weights = {{"volume", "eigenvalue", "equal", "source", "destination"}};
  const std::array<std::string, 3> sides = {{"source", "destination", "both"}};
  const std::array<std::string, 3> extensions = {{"symmetric", "trial", "none"}};
  unsigned int n_choices = 0;
  for (const Laws &laws : all_laws) {
    Errors errors;
    // seven choices per law, each theta with different companions; over all laws every pair occurs
    for (unsigned int i = 0; i < 7; ++i, ++n_choices) {
      const Choice choice = {thetas[i % 4], weights[(i + i / 4 + n_choices / 7) % 5], sides[n_choices % 3],
                             extensions[(n_choices + n_choices / 3) % 3]};
      const Errors of_choice = check<dim>(laws, choice, degree, n_groups);
      errors.tangent = std::max(errors.tangent, of_choice.tangent);
      errors.coupling = std::max(errors.coupling, of_choice.coupling);
      errors.balance = std::max(errors.balance, of_choice.balance);
      errors.variations += of_choice.variations;
      errors.curvatures += of_choice.curvatures;
      if (choice.theta == "1" && choice.extension != "trial" && laws.is_symmetric) {
        Choice strong = choice; // else points at which the penalty is too small turn skew-symmetric
        strong.multiplier = "100";
        errors.symmetry = std::max(errors.symmetry, check<dim>(laws, strong, degree, n_groups).symmetry);
      }
    }
    const std::string name =
        std::to_string(dim) + "D, degree " + std::to_string(degree) + ", " + laws.name + ": ";
    report(name + "tangent", errors.tangent, 1e-7);
    report(name + "balance", errors.balance, 1e-12);
    if (laws.is_symmetric)
      report(name + "symmetric for theta = 1", errors.symmetry, 1e-12);
    report(name + "couplings", errors.coupling, 0.);
    report(name + "needless variations", errors.variations + errors.curvatures, 0.);
  }
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string expansion = set("Expansion coefficient", "0.03") + set("Reference temperature", "2.5");
  const Laws conduction = {"k(T)", heat("1 + 0.1*T^2"), heat("2 + x + 0.3*T"), 0, false};
  const Laws linear_conduction = {"k(x)", heat("2 + x; 1"), heat("3"), 0, true};
  const Laws linear = {"linear elastic", solid("linear elastic"), solid("linear elastic"), 0.05, true};
  const Laws saint_venant = {"Saint Venant-Kirchhoff", solid("Saint Venant-Kirchhoff"),
                             solid("Saint Venant-Kirchhoff"), 0.03, true};
  const Laws neo_hookean = {"neo-Hookean", solid("neo-Hookean"), solid("neo-Hookean"), 0.03, true};
  const Laws mixed = {"linear elastic to neo-Hookean", solid("linear elastic"), solid("neo-Hookean"), 0.03,
                      true};
  const Laws thermoelastic = {"linear thermo-elastic", solid("linear elastic", expansion) + heat("1 + 0.1*T"),
                              solid("linear elastic") + heat("2"), 0.03, false};
  const Laws coupled = {"thermo-elastic", solid("neo-Hookean", expansion) + heat("1 + 0.1*T"),
                        solid("Saint Venant-Kirchhoff", expansion) + heat("2"), 0.03, false};

  test_laws<2>({linear_conduction,
                conduction,
                {"tensor k(T)", heat("2 + 0.1*T; 0.3*T; 0.1; 1 + x"), heat("1; 2 + 0.2*T"), 0, false},
                linear,
                saint_venant,
                neo_hookean,
                mixed,
                thermoelastic,
                coupled},
               1, 10);
  test_laws<2>({conduction, neo_hookean, coupled}, 2, 1);
  const auto with_pressure = [&](const std::string &type) {
    const std::string law = solid(type, set("Formulation", "mixed"));
    return Laws{type + ", mixed", law, law, 0.03, true};
  };
  test_laws<2>({with_pressure("linear elastic"), with_pressure("neo-Hookean"),
                with_pressure("neo-Hookean").with_joint("", "0.7; 3")},
               2, 1);
  test_laws<2>({linear_conduction.with_joint("2 + y", ""), conduction.with_joint("3", ""),
                conduction.with_joint("0.1*T^2 + x", ""), linear.with_joint("", "0.7; 3"),
                neo_hookean.with_joint("", "0; 1e9"), coupled.with_joint("1e5*T", "5*x"),
                coupled.with_joint("0.1*T^2", "0.7; 3 + t")},
               1, 4);
  const std::string by_contact = "exp(p) + 3*gap^2 + 0.1*T";
  test_laws<2>({thermoelastic.with_contact(by_contact), coupled.with_contact(by_contact),
                coupled.with_contact(by_contact).around_axis()},
               1, 4);
  test_laws<2>({coupled.with_contact(by_contact)}, 2, 1);
  test_laws<3>({coupled.with_contact(by_contact)}, 1, 1);
  const std::string breaks =
                        set("Joint", "bilinear") + set("Strength", "0.02") + set("Fracture energy", "0.001"),
                    in_two_modes = set("Joint", "bilinear") + set("Strength", "0.01; 0.02") +
                                   set("Fracture energy", "0.001; 0.003"),
                    by_formula =
                        set("Joint", "formula") + set("Traction", "2*n*exp(-30*n - 20*s); 3*s/(1 + 10*s)");
  test_laws<2>({linear.with_law("breaks", breaks, true), neo_hookean.with_law("breaks", breaks, true),
                neo_hookean.with_law("breaks in two modes", in_two_modes, false),
                linear.with_law("joint by formula", by_formula, false)},
               1, 4);
  test_laws<2>({neo_hookean.with_law("breaks in two modes", in_two_modes, false).around_axis()}, 1, 4);
  test_laws<3>({saint_venant.with_law("breaks in two modes", in_two_modes, false)}, 1, 1);
  test_laws<2>({conduction.around_axis(), linear.around_axis(), neo_hookean.around_axis(),
                coupled.around_axis(), coupled.with_joint("0.1*T^2", "0.7; 3 + t").around_axis()},
               1, 6);
  test_laws<3>(
      {conduction,
       {"tensor k(T)", heat("3; 0.1*T; 0; 0.2; 2 + 0.1*T; 0; 0.1; 0; 1"), heat("1; 2; 1 + 0.1*T"), 0, false},
       saint_venant,
       coupled,
       saint_venant.with_joint("", "0.7; 3"),
       coupled.with_joint("0.1*T^2", "3; 0")},
      1, 1);
}
