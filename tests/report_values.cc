// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
//   report_values CHECKS REPORT.json…
//
// Prints what the lines of the file CHECKS ask for, each evaluated in every report:
//
//   check EXPRESSION            its value, six digits, one line per report
//   check EXPRESSION < NUMBER   yes, or no and the value; also >
//   rate EXPRESSION             log2 of the ratio of successive reports, for runs that halve the mesh size
//   rounding NUMBER             how much of what flows rounding may hide in the steps in time of this scene
//
// EXPRESSION is operands joined by ` + `, ` - `, ` * `, ` / ` with the usual precedence, or in parentheses
// with blanks inside, `( a + b ) / c`; an operand is a number or the path of a value in the report, like
// interfaces/seam/jump L2/temperature or steps/-1/newton iterations
// (-1: the last). Arrays are taken component by component. A field of a domain that is not in balance at the
// end, or a step in time that is not (to 1e-10, or to `rounding` where the program says that rounding hides
// as much), or that loses energy, adds a line.

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace {
using Values = std::vector<double>;

std::string six_digits(const double value)
{
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g", value);
  return text;
}

bool is_number(const std::string &text)
{
  char *end = nullptr;
  std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0';
}

const nlohmann::json &find(const nlohmann::json &report, const std::string &path)
{
  const nlohmann::json *place = &report;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    const std::string key = path.substr(begin, end - begin);
    begin = end + 1;
    if (place->is_array() && is_number(key)) {
      const int index = std::stoi(key);
      place = &place->at(index < 0 ? place->size() + index : index);
    } else if (place->is_object() && place->contains(key))
      place = &place->at(key);
    else
      throw std::runtime_error("the report has no '" + key + "' of the path '" + path + "'");
  }
  return *place;
}

Values operand(const nlohmann::json &report, const std::string &text)
{
  if (is_number(text))
    return {std::stod(text)};
  const nlohmann::json &found = find(report, text);
  if (found.is_array())
    return found.get<Values>();
  if (found.is_number())
    return {found.get<double>()};
  throw std::runtime_error("'" + text + "' is no number but " + found.dump());
}

// Where the next ` c ` with c from operators stands.
std::size_t next_operator(const std::string &text, const std::string &operators, const std::size_t begin)
{
  for (std::size_t i = begin; i + 2 < text.size(); ++i)
    if (text[i] == ' ' && text[i + 2] == ' ' && operators.find(text[i + 1]) != std::string::npos)
      return i;
  return std::string::npos;
}

Values combine(const Values &left, const char operation, Values right)
{
  if (right.size() == 1)
    right.resize(left.size(), right[0]);
  if (right.size() != left.size())
    throw std::runtime_error("different numbers of components");
  for (std::size_t i = 0; i < left.size(); ++i)
    right[i] = operation == '+'   ? left[i] + right[i]
               : operation == '-' ? left[i] - right[i]
               : operation == '*' ? left[i] * right[i]
                                  : left[i] / right[i];
  return right;
}

/// Where the last operator out of @p operators stands that is in no parentheses.
std::size_t last_operator(const std::string &text, const std::string &operators)
{
  int depth = 0;
  for (std::size_t i = text.size(); i-- > 0;) {
    const bool ends_word = i + 1 == text.size() || text[i + 1] == ' ',
               begins_word = i == 0 || text[i - 1] == ' ';
    if (!ends_word || !begins_word)
      continue;
    depth += text[i] == ')' ? 1 : text[i] == '(' ? -1 : 0;
    if (depth == 0 && i > 1 && i + 2 < text.size() && operators.find(text[i]) != std::string::npos)
      return i;
  }
  return std::string::npos;
}

Values evaluate(const nlohmann::json &report, const std::string &expression)
{
  for (const char *const operators : {"+-", "*/"})
    if (const std::size_t at = last_operator(expression, operators); at != std::string::npos)
      return combine(evaluate(report, expression.substr(0, at - 1)), expression[at],
                     evaluate(report, expression.substr(at + 2)));
  if (expression.size() > 4 && expression.substr(0, 2) == "( " &&
      expression.substr(expression.size() - 2) == " )")
    return evaluate(report, expression.substr(2, expression.size() - 4));
  return operand(report, expression);
}

bool is_text(const nlohmann::json &value)
{
  return value.is_array() ? !value.empty() && value[0].is_string() : !value.is_number();
}

void check(const std::vector<nlohmann::json> &reports, const std::string &expression)
{
  const std::size_t comparison = next_operator(expression, "<>", 0);
  for (const nlohmann::json &report : reports) {
    std::cout << expression << ':';
    if (comparison != std::string::npos) {
      const Values bound = operand(report, expression.substr(comparison + 3));
      bool holds = true;
      std::string values;
      for (const double value : evaluate(report, expression.substr(0, comparison))) {
        holds = holds && (expression[comparison + 1] == '<' ? value < bound[0] : value > bound[0]);
        values += ' ' + six_digits(value);
      }
      std::cout << (holds ? " yes" : " no," + values);
    } else if (next_operator(expression, "+-*/", 0) == std::string::npos && !is_number(expression) &&
               is_text(find(report, expression)))
      std::cout << ' ' << find(report, expression).dump(); // true, a text, several of them
    else
      for (const double value : evaluate(report, expression))
        std::cout << ' ' << six_digits(value);
    std::cout << '\n';
  }
}

void rate(const std::vector<nlohmann::json> &reports, const std::string &expression)
{
  std::cout << "rate of " << expression << ':';
  for (std::size_t i = 1; i < reports.size(); ++i) {
    char text[32];
    std::snprintf(
        text, sizeof(text), " %.3g",
        std::log2(evaluate(reports[i - 1], expression).at(0) / evaluate(reports[i], expression).at(0)));
    std::cout << text;
  }
  std::cout << '\n';
}
// The largest component, as a size.
double largest(const nlohmann::json &value)
{
  double result = 0;
  for (const nlohmann::json &component : value.is_array() ? value : nlohmann::json::array({value}))
    result = std::max(result, component.is_number() ? std::abs(component.get<double>()) : INFINITY);
  return result;
}

// Newton's method ends at its tolerance; the sum of nodal residuals may be some times their norm.
double allowed_imbalance(const nlohmann::json &report)
{
  const auto &steps = report.at("steps");
  for (const auto &step : steps)
    if (step.at("newton iterations") > 1)
      return std::max(1e-10, 10 * steps.back().at("residuals").back().get<double>());
  return 1e-10;
}

// Prints the step in time of which most is missing, if that is more than 1e-10 of what flows or is stored, or
// than the scene says of rounding where the program finds that rounding can hide as much. Where the program
// finds no imbalance since nothing flows but rounding, there is none.
void check_steps(const nlohmann::json &report, const double rounding_of_scene)
{
  const std::string in_time = "rates in time";
  bool is_in_time = false;
  for (const std::string line : report.value("plan", nlohmann::json::array()))
    is_in_time = is_in_time || line.rfind(in_time, 0) == 0;
  const nlohmann::json *worst = nullptr;
  double largest_excess = 1;
  const nlohmann::json steps = report.value("steps", nlohmann::json::array());
  for (const auto &step : steps)
    if (is_in_time && step.contains("imbalance")) {
      const double excess =
          step.at("imbalance").is_number()
              ? step.at("imbalance").get<double>() /
                    std::max(1e-10, std::min(rounding_of_scene, step.value("rounding of imbalance", 0.)))
              : HUGE_VAL;
      if (excess > largest_excess) {
        largest_excess = excess;
        worst = &step;
      }
    }
  if (worst != nullptr)
    std::cout << "no balance of the step to t = " << worst->at("time") << ": " << worst->at("imbalance")
              << '\n';
}

// Prints the step of a linear scene with inertia that loses something else than what its time scheme takes,
// by more than 1e-10 of the largest energy and work so far. Where materials change by phase, so does their
// energy.
void check_energy(const nlohmann::json &report)
{
  for (const std::string line : report.value("plan", nlohmann::json::array()))
    if (line.find(" or ") != std::string::npos) // "linear elastic or linear elastic"
      return;
  double scale = 0, lost_before = 0;
  std::string all_known; // of the first step
  for (const auto &step : report.value("steps", nlohmann::json::array())) {
    std::string known;
    for (const char *const name : {"scheme", "ties"})
      known += step.contains("energy") && step.at("energy").contains(name) ? name : "-";
    all_known = all_known.empty() ? known : all_known;
    if (known != all_known)
      std::cout << "the energy of the step to t = " << step.at("time") << " is known by " << known
                << ", that of the first by " << all_known << '\n';
    if (step.at("newton iterations") > 1 || known != "schemeties")
      return;
    const auto &energy = step.at("energy");
    for (const char *const name : {"kinetic", "elastic", "work", "lost"})
      scale = std::max(scale, largest(energy.at(name)));
    const double lost = energy.at("lost").get<double>() - energy.at("scheme").get<double>();
    if (!(std::abs(lost - lost_before) <= 1e-10 * scale))
      std::cout << "energy is lost in the step to t = " << step.at("time") << ": " << lost - lost_before
                << " of " << scale << '\n';
    lost_before = lost;
  }
}

// Prints what of the balance of a run that has converged does not hold to 1e-10 of what flows (nonlinear: to
// 1e-9).
void check_balance(const nlohmann::json &report)
{
  if (!report.at("converged"))
    return;
  std::map<std::string, double>
      flows; // of a field, in any body: a body at rest has the rounding of the others
  for (const auto &[domain, fields] : report.at("balance").items())
    for (const auto &[field, balance] : fields.items())
      flows[field] = std::max({flows[field], largest(balance.at("in")), largest(balance.at("out"))});
  for (const auto &[domain, fields] : report.at("balance").items())
    for (const auto &[field, balance] : fields.items()) {
      const double own = std::max(largest(balance.at("in")), largest(balance.at("out")));
      const double bound = std::max(
          {allowed_imbalance(report) * own, 1e-14 * flows[field], balance.value("rounding", 0.), 1e-16});
      if (!(largest(balance.at("imbalance")) <= bound))
        std::cout << "no balance of the " << field << " of " << domain << ": " << balance.dump() << '\n';
    }
}
} // namespace

int main(int argc, char **argv)
{
  try {
    std::vector<nlohmann::json> reports;
    for (int i = 2; i < argc; ++i) {
      std::ifstream file(argv[i]);
      reports.push_back(nlohmann::json::parse(file));
    }
    std::ifstream checks(argv[1]);
    bool any = false;
    double rounding = 0;
    for (std::string kind, expression; checks >> kind >> std::ws && std::getline(checks, expression);) {
      expression.erase(expression.find_last_not_of(" \t\r") + 1);
      any = any || kind != "rounding";
      if (kind == "rounding")
        rounding = std::stod(expression);
      else if (kind == "rate")
        rate(reports, expression);
      else
        check(reports, expression);
    }
    for (const nlohmann::json &report : reports) {
      check_balance(report);
      check_steps(report, rounding);
      check_energy(report);
    }
    if (!any)
      throw std::runtime_error("the scene has no comment `# check: …`, so nothing would be compared");
  } catch (const std::exception &error) {
    std::cout << "report_values: " << error.what() << std::endl;
    return 1;
  }
}
