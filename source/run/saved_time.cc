// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/saved_time.h>

namespace dovetail {

namespace {

std::string numbered(const std::string &name, const unsigned int i)
{
  return name + " " + std::to_string(i);
}

void save(const std::string &name, const std::vector<Vector> &vectors, SavedState &to)
{
  for (unsigned int i = 0; i < vectors.size(); ++i)
    to.vectors[numbered(name, i)] = vectors[i];
}

std::vector<Vector> saved(const std::string &name, const SavedState &from)
{
  std::vector<Vector> vectors;
  for (auto found = from.vectors.find(numbered(name, 0)); found != from.vectors.end();
       found = from.vectors.find(numbered(name, vectors.size())))
    vectors.push_back(found->second);
  return vectors;
}

} // namespace

void save_memory(const TimeMemory &memory, SavedState &to)
{
  const StepTime &last = memory.last;
  to.numbers["time scheme"] = {{"last step", {last.begin, last.end, last.size}},
                               {"starts anew", last.starts_anew},
                               {"sizes", memory.sizes}};
  save("state", memory.states, to);
  save("rate", memory.rates, to);
  save("second rate", memory.second_rates, to);
}

TimeMemory saved_memory(const SavedState &from)
{
  const auto &numbers = from.numbers["time scheme"];
  const std::vector<double> last = numbers["last step"];
  return {{last[0], last[1], last[2], numbers["starts anew"]},
          numbers["sizes"],
          saved("state", from),
          saved("rate", from),
          saved("second rate", from)};
}

void save_rates(const Rates &rates, SavedState &to)
{
  to.numbers["rates"] = {rates.by_value, rates.second_by_value};
  if (rates.has_first())
    to.vectors["rest of rate"] = rates.rest;
  if (rates.has_second())
    to.vectors["rest of second rate"] = rates.second_rest;
  to.numbers["weights of past"] = rates.weights;
  save("past of rate", rates.past, to);
}

Rates saved_rates(const SavedState &from)
{
  Rates rates;
  rates.by_value = from.numbers["rates"][0];
  rates.second_by_value = from.numbers["rates"][1];
  if (const auto rest = from.vectors.find("rest of rate"); rest != from.vectors.end())
    rates.rest = rest->second;
  if (const auto rest = from.vectors.find("rest of second rate"); rest != from.vectors.end())
    rates.second_rest = rest->second;
  rates.weights = from.numbers["weights of past"].get<std::vector<double>>();
  rates.past = saved("past of rate", from);
  return rates;
}

void save_predictor(const Predictor &predictor, SavedState &to)
{
  std::vector<double> times;
  std::vector<Vector> solutions;
  for (const auto &[time, x] : predictor.all()) {
    times.push_back(time);
    solutions.push_back(x);
  }
  to.numbers["times of predictor"] = times;
  save("solution of predictor", solutions, to);
}

Predictor saved_predictor(const SavedState &from)
{
  Predictor predictor;
  const std::vector<double> times = from.numbers["times of predictor"];
  const std::vector<Vector> solutions = saved("solution of predictor", from);
  for (unsigned int i = 0; i < times.size(); ++i)
    predictor.add(times[i], solutions[i]);
  return predictor;
}

} // namespace dovetail
