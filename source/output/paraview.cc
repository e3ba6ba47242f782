// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/paraview.h>
#include <dovetail/output/report.h>

#include <deal.II/numerics/data_out.h>
#include <deal.II/numerics/data_postprocessor.h>

#include <fstream>
#include <iomanip>
#include <limits>
#include <sstream>

namespace dovetail {

namespace {

namespace Interpretation = dealii::DataComponentInterpretation;

/// What the laws say of a solution: heat flux, Cauchy stress, von Mises.
template <int dim>
class Derived : public dealii::DataPostprocessor<dim>
{
public:
  Derived(const Material<dim> &material, const std::set<std::string> &fields, const double t)
      : material(material), t(t)
  {
    has_heat_flux = fields.count("heat flux") > 0 && material.find_field("temperature") != nullptr;
    const bool is_solid = material.find_field("displacement") != nullptr;
    has_stress = fields.count("Cauchy stress") > 0 && is_solid;
    has_von_mises = fields.count("von Mises") > 0 && is_solid;
    if (has_heat_flux)
      declare("heat flux", dim, Interpretation::component_is_part_of_vector);
    if (has_stress)
      declare("Cauchy stress", dim * dim, Interpretation::component_is_part_of_tensor);
    if (has_stress && dim == 2)
      declare("Cauchy stress zz", 1, Interpretation::component_is_scalar);
    if (has_von_mises)
      declare("von Mises", 1, Interpretation::component_is_scalar);
  }

  bool is_empty() const { return names.empty(); }
  std::vector<std::string> get_names() const override { return names; }
  std::vector<Interpretation::DataComponentInterpretation> get_data_component_interpretation() const override
  {
    return interpretations;
  }
  dealii::UpdateFlags get_needed_update_flags() const override
  {
    return dealii::update_values | dealii::update_gradients | dealii::update_quadrature_points;
  }

  void evaluate_scalar_field(const dealii::DataPostprocessorInputs::Scalar<dim> &inputs,
                             std::vector<dealii::Vector<double>> &results) const override
  {
    State<dim> state(1);
    for (unsigned int p = 0; p < results.size(); ++p) {
      state.value[0] = inputs.solution_values[p];
      state.gradient[0] = inputs.solution_gradients[p];
      evaluate(inputs.evaluation_points[p], state, results[p]);
    }
  }

  void evaluate_vector_field(const dealii::DataPostprocessorInputs::Vector<dim> &inputs,
                             std::vector<dealii::Vector<double>> &results) const override
  {
    State<dim> state(material.n_components());
    for (unsigned int p = 0; p < results.size(); ++p) {
      for (unsigned int c = 0; c < state.value.size(); ++c) {
        state.value[c] = inputs.solution_values[p][c];
        state.gradient[c] = inputs.solution_gradients[p][c];
      }
      evaluate(inputs.evaluation_points[p], state, results[p]);
    }
  }

private:
  void declare(const std::string &name, const unsigned int n_components,
               const Interpretation::DataComponentInterpretation interpretation)
  {
    names.insert(names.end(), n_components, name);
    interpretations.insert(interpretations.end(), n_components, interpretation);
  }

  void evaluate(const dealii::Point<dim> &X, State<dim> &state, dealii::Vector<double> &result) const
  {
    state.X = X;
    state.t = t;
    unsigned int i = 0;
    if (has_heat_flux) {
      Response<dim> response(material.n_components());
      const bool is_defined = material.evaluate(state, false, response);
      const auto &influx = response.flux[material.find_field("temperature")->first_component];
      for (unsigned int d = 0; d < dim; ++d)
        result[i++] = is_defined ? -influx[d] : std::numeric_limits<double>::quiet_NaN();
    }
    if (!has_stress && !has_von_mises)
      return;
    const dealii::Tensor<2, 3> sigma = material.cauchy_stress(state);
    if (has_stress) {
      for (unsigned int j = 0; j < dim; ++j)
        for (unsigned int k = 0; k < dim; ++k)
          result[i++] = sigma[j][k];
      if (dim == 2)
        result[i++] = sigma[2][2];
    }
    if (has_von_mises)
      result[i++] = von_mises(sigma);
  }

  static double von_mises(const dealii::Tensor<2, 3> &sigma)
  {
    const auto stress = symmetrize(sigma);
    return std::sqrt(1.5) * deviator(stress).norm();
  }

  const Material<dim> &material;
  const double t;
  bool has_heat_flux, has_stress, has_von_mises;
  std::vector<std::string> names;
  std::vector<Interpretation::DataComponentInterpretation> interpretations;
};

template <int dim>
bool some_domain_has(const Model<dim> &model, const std::string &field)
{
  return std::any_of(model.domains.begin(), model.domains.end(),
                     [&](const auto &domain) { return domain->material.find_field(field) != nullptr; });
}

dealii::DataOutBase::VtkFlags flags(const double time)
{
  dealii::DataOutBase::VtkFlags result;
  result.time = time;
  result.compression_level = decltype(result.compression_level)::best_speed;
  return result;
}

std::string file_of(const std::string &stem, const unsigned int step)
{
  std::ostringstream name;
  name << "steps/" << stem << '.' << std::setw(4) << std::setfill('0') << step << ".vtu";
  return name.str();
}

std::string escape(const std::string &text)
{
  std::string result;
  for (const char c : text)
    result += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string(1, c);
  return result;
}

} // namespace

template <int dim>
Paraview<dim>::Paraview(const Section &output, const Model<dim> &model, const std::string &directory)
    : model(model), directory(directory),
      writes(output.read<bool>("Paraview", true, "Write files that ParaView opens [-]"))
{
  read_fields(output);
}

template <int dim>
void Paraview<dim>::prepare()
{
  for (const auto &domain : model.domains) {
    blocks.emplace_back();
    blocks.back().name = domain->name;
    blocks.back().domain = domain.get();
  }
  for (const auto &interface : model.interfaces) {
    blocks.emplace_back();
    blocks.back().name = interface->name;
    blocks.back().surface = std::make_unique<InterfaceSurface<dim>>(*interface);
  }
  name_files();
  make_directory(directory + "/steps", model.communicator);
}

template <int dim>
Paraview<dim>::~Paraview() = default;

template <int dim>
void Paraview<dim>::read_fields(const Section &output)
{
  const std::vector<std::string> known = {"solution", "heat flux", "Cauchy stress", "von Mises"};
  const auto asked = output.read<std::vector<std::string>>(
      "Fields", {"solution"}, "What the files show, of: solution, heat flux, Cauchy stress, von Mises [-]");
  for (const std::string &field : asked) {
    output.check(std::find(known.begin(), known.end(), field) != known.end(), "Fields",
                 "has '" + field + "', but known are " + comma_separated(known) + ". " +
                     did_you_mean(field, known));
    output.check(field == "solution" || field == "heat flux" || some_domain_has(model, "displacement"),
                 "Fields",
                 "asks for " + field + ", but no material has a solid law. Remove it from the list.");
    output.check(field != "heat flux" || some_domain_has(model, "temperature"), "Fields",
                 "asks for heat flux, but no material has a heat law. Remove it from the list.");
  }
  fields = {asked.begin(), asked.end()};
}

/// Letters, digits, '-' and '_' only, and no name twice, also where upper and lower case are the same.
template <int dim>
void Paraview<dim>::name_files()
{
  std::set<std::string> taken;
  for (Block &block : blocks) {
    std::string safe;
    for (const char c : block.name)
      safe += std::isalnum(static_cast<unsigned char>(c)) || c == '-' ? c : '_';
    const auto lower_case = [](std::string text) {
      std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
      return text;
    };
    block.stem = safe;
    for (unsigned int i = 2; !taken.insert(lower_case(block.stem)).second; ++i)
      block.stem = safe + "_" + std::to_string(i);
  }
}

template <int dim>
void Paraview<dim>::write(const double time, const Vector &solution)
{
  if (!writes)
    return;
  if (blocks.empty())
    prepare();
  for (const Block &block : blocks) {
    const std::string file = directory + "/" + file_of(block.stem, times.size());
    if (block.domain != nullptr)
      write_domain(*block.domain, time, solution, file);
    else {
      block.surface->update(solution, time);
      block.surface->set_flags(flags(time));
      block.surface->write_vtu_in_parallel(file, model.communicator);
    }
  }
  times.push_back(time);
  if (dealii::Utilities::MPI::this_mpi_process(model.communicator) == 0)
    write_index();
}

template <int dim>
void Paraview<dim>::write_domain(const Domain<dim> &domain, const double time, const Vector &solution,
                                 const std::string &file) const
{
  const auto unknowns = domain_vector(domain, solution);
  const Derived<dim> derived(domain.material, fields, time);
  dealii::DataOut<dim> data;
  data.set_flags(flags(time));
  data.attach_dof_handler(domain.dof_handler());
  if (fields.count("solution") > 0) {
    std::vector<std::string> names;
    std::vector<Interpretation::DataComponentInterpretation> interpretations;
    for (const Field &field : domain.fields()) {
      names.insert(names.end(), field.n_components, field.name);
      interpretations.insert(interpretations.end(), field.n_components,
                             field.n_components > 1 ? Interpretation::component_is_part_of_vector
                                                    : Interpretation::component_is_scalar);
    }
    data.add_data_vector(unknowns, names, dealii::DataOut<dim>::type_dof_data, interpretations);
  }
  if (!derived.is_empty())
    data.add_data_vector(unknowns, derived);
  data.build_patches(domain.mapping(), domain.degree,
                     domain.mapping_degree() > 1 ? dealii::DataOut<dim>::curved_inner_cells
                                                 : dealii::DataOut<dim>::no_curved_cells);
  data.write_vtu_in_parallel(file, model.communicator);
}

/// Written beside and then renamed, so that it is whole whenever somebody opens it.
template <int dim>
void Paraview<dim>::write_index() const
{
  const std::string name = directory + "/solution.pvd";
  {
    std::ofstream index(name + ".new");
    index << "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n";
    index << std::setprecision(16);
    for (unsigned int step = 0; step < times.size(); ++step)
      for (unsigned int b = 0; b < blocks.size(); ++b)
        index << "<DataSet timestep=\"" << times[step] << "\" part=\"" << b << "\" name=\""
              << escape(blocks[b].name) << "\" file=\"" << file_of(blocks[b].stem, step) << "\"/>\n";
    index << "</Collection>\n</VTKFile>\n";
  }
  std::rename((name + ".new").c_str(), name.c_str());
}

template class Paraview<2>;
template class Paraview<3>;

} // namespace dovetail
