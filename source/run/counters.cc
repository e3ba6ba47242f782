// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/counters.h>

namespace dovetail {

template <int dim>
nlohmann::ordered_json count(const Model<dim> &model, const typename BlockSystem<dim>::Assemblies &assemblies,
                             const LinearSolver &solver, const unsigned int n_predicted,
                             const unsigned int n_files)
{
  const auto sum = [&](const unsigned long own) {
    return dealii::Utilities::MPI::sum(own, model.communicator);
  };
  const auto evaluations = [&](const std::string &law) {
    unsigned long n = 0;
    for (const auto &material : model.materials)
      n += material->evaluations(law);
    return sum(n);
  };
  FluxVariations variations;
  InterfaceWork work;
  for (const auto &interface : model.interfaces) {
    if (const PointTerms<dim> *terms = interface->tie().parts().point_terms) {
      variations.first += terms->flux_variations().first;
      variations.second += terms->flux_variations().second;
    }
    work += interface->work();
  }
  LinearSolver::Counts linear = solver.counts();
  GroupSolver::Preparations multigrids;
  for (const auto &[name, preparations] : linear.preparations)
    if (name != "direct") {
      multigrids.made += preparations.made;
      multigrids.kept += preparations.kept;
    }
  nlohmann::ordered_json counters = {{"tangent assemblies", assemblies.tangents},
                                     {"residual assemblies", assemblies.residuals_alone},
                                     {"tangents by sums", assemblies.tangents_by_sums},
                                     {"residuals by products", assemblies.residuals_by_products},
                                     {"predicted steps", n_predicted},
                                     {"linear solves", linear.solves},
                                     {"factorisations", linear.preparations["direct"].made},
                                     {"multigrids", multigrids.made},
                                     {"multigrids kept", multigrids.kept},
                                     {"solid law evaluations", evaluations("solid")},
                                     {"heat law evaluations", evaluations("heat")},
                                     {"first flux variations", sum(variations.first)},
                                     {"second flux variations", sum(variations.second)},
                                     {"trace eigenvalue problems", sum(work.eigenvalue_problems)},
                                     {"face locators", work.locators},
                                     {"faces exchanged", sum(work.faces)},
                                     {"messages of interfaces", sum(work.messages)},
                                     {"bytes of interfaces", sum(work.bytes)},
                                     {"ParaView files", n_files}};
  for (const auto &interface : model.interfaces)
    counters["interfaces"][interface->name] = {{"face locators", interface->work().locators},
                                               {"faces exchanged", sum(interface->work().faces)},
                                               {"messages", sum(interface->work().messages)},
                                               {"bytes", sum(interface->work().bytes)}};
  return counters;
}

template nlohmann::ordered_json count(const Model<2> &, const BlockSystem<2>::Assemblies &,
                                      const LinearSolver &, unsigned int, unsigned int);
template nlohmann::ordered_json count(const Model<3> &, const BlockSystem<3>::Assemblies &,
                                      const LinearSolver &, unsigned int, unsigned int);

} // namespace dovetail
