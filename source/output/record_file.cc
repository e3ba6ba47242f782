// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/bytes.h>
#include <dovetail/output/record_file.h>
#include <dovetail/output/shared_file.h>
#include <dovetail/scene/user_error.h>

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <utility>
#include <vector>

namespace dovetail {

namespace {

using nlohmann::ordered_json;

constexpr const char *begin_anew = " Run the scene from its beginning, without --resume.";

/// In this order; of bytes that another machine writes in another one.
std::string order_of_bytes()
{
  std::string bytes;
  add_number<std::uint32_t>(0x64636261, bytes);
  return bytes;
}

struct FirstLine
{
  unsigned int format = 0;
  std::uint64_t n_bytes = 0, sum = 0; ///< of the header

  std::string text() const
  {
    std::ostringstream line;
    line << RecordFile::first_words << ' ' << format << ' ' << order_of_bytes() << ' ' << n_bytes << ' '
         << sum << '\n';
    return line.str();
  }
};

std::string received(std::string bytes, const MPI_Comm &communicator)
{
  const std::uint64_t largest_message = 1 << 24;
  std::uint64_t n = bytes.size();
  MPI_Bcast(&n, 1, MPI_UINT64_T, 0, communicator);
  bytes.resize(n);
  for (std::uint64_t begin = 0; begin < n; begin += largest_message)
    MPI_Bcast(&bytes[begin], std::min(largest_message, n - begin), MPI_CHAR, 0, communicator);
  return bytes;
}

bool is_first(const MPI_Comm &communicator)
{
  return dealii::Utilities::MPI::this_mpi_process(communicator) == 0;
}

} // namespace

Obstacle RecordFile::write(const std::string &name, ordered_json header, const Records &records,
                           const MPI_Comm &communicator)
{
  std::vector<std::pair<std::uint64_t, std::uint64_t>> own; // size, checksum
  for (const auto &[record, part] : records)
    own.emplace_back(part.size(), checksum(part));
  const auto of_ranks = dealii::Utilities::MPI::gather(communicator, own);
  SharedFile file(name, first_words, communicator);
  std::string beginning;
  if (is_first(communicator)) {
    unsigned int i = 0;
    for (const auto &[record, part] : records) {
      for (const auto &rank : of_ranks)
        header["records"][record].push_back(rank[i]);
      ++i;
    }
    const std::string text = header.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
    beginning = FirstLine{format, text.size(), checksum(text)}.text() + text;
  }
  file.append(beginning);
  for (const auto &[record, part] : records)
    file.append(part);
  return file.finish();
}

RecordReader::RecordReader(const std::string &name, const MPI_Comm &communicator)
    : name(name), communicator(communicator)
{
  std::string line;
  std::uint64_t size = 0;
  if (is_first(communicator)) {
    file.open(name, std::ios::binary);
    std::getline(file, line);
    std::error_code error;
    size = std::filesystem::file_size(name, error);
    line = file ? line + "\n" : "";
    size = error ? 0 : size;
  }
  line = received(line, communicator);
  size = dealii::Utilities::MPI::broadcast(communicator, size);
  if (line.empty() && size == 0)
    throw UserError(
        "There is no checkpoint to go on from: '" + name +
        "' is not there or cannot be read. The scene's Directory in the subsection Output must be "
        "that of the run that goes on, and its Checkpoint every steps must have been set.");
  check_first_line(line);
  FirstLine found;
  std::string word;
  std::istringstream(line) >> word >> word >> found.format >> word >> found.n_bytes >> found.sum;
  const std::string text =
      size < line.size() + found.n_bytes ? "" : received(read_here(line.size(), found.n_bytes), communicator);
  if (text.empty() || checksum(text) != found.sum)
    refuse("is damaged: its header is not what was written.");
  content = ordered_json::parse(text);
  begin_of_records = line.size() + text.size();
  std::uint64_t end = begin_of_records;
  for (const auto &record : content["records"])
    for (const auto &part : record)
      end += part[0].get<std::uint64_t>();
  if (size != end)
    refuse("is damaged: it has " + std::to_string(size) + " bytes instead of " + std::to_string(end) + ".");
  check_records();
}

void RecordReader::refuse(const std::string &why) const
{
  throw UserError("The checkpoint '" + name + "' " + why + begin_anew);
}

void RecordReader::check_first_line(const std::string &line) const
{
  const std::string kind = std::string(RecordFile::first_words) + " ";
  if (line.rfind(kind, 0) != 0)
    refuse("is damaged: it does not begin as a checkpoint of Dovetail does.");
  FirstLine found;
  std::string order;
  std::istringstream(line.substr(kind.size())) >> found.format >> order;
  if (found.format != RecordFile::format)
    refuse("was written by another version of Dovetail, in format " + std::to_string(found.format) +
           " instead of " + std::to_string(RecordFile::format) + ".");
  if (order != order_of_bytes())
    refuse("was written by a machine that orders bytes in another way.");
}

/// On the first rank; nothing on others.
std::string RecordReader::read_here(const std::uint64_t begin, const std::uint64_t n_bytes) const
{
  std::string bytes;
  if (is_first(communicator)) {
    bytes.resize(n_bytes);
    file.clear();
    file.seekg(begin);
    file.read(&bytes[0], n_bytes);
    bytes.resize(file.gcount());
  }
  return bytes;
}

/// Before anybody takes anything from them.
void RecordReader::check_records() const
{
  std::uint64_t begin = begin_of_records;
  std::string damaged;
  if (is_first(communicator))
    for (const auto &[record, parts] : content["records"].items())
      for (const auto &part : parts) {
        const auto n_bytes = part[0].get<std::uint64_t>();
        if (checksum(read_here(begin, n_bytes)) != part[1].get<std::uint64_t>())
          damaged = record;
        begin += n_bytes;
      }
  damaged = received(damaged, communicator);
  if (!damaged.empty())
    refuse("is damaged: its record '" + damaged + "' is not what was written.");
}

void RecordReader::for_each_part(const std::string &wanted,
                                 const std::function<void(const std::string &part)> &visit) const
{
  std::uint64_t begin = begin_of_records;
  for (const auto &[record, parts] : content["records"].items())
    for (const auto &part : parts) {
      const auto n_bytes = part[0].get<std::uint64_t>();
      if (record == wanted)
        visit(received(read_here(begin, n_bytes), communicator));
      begin += n_bytes;
    }
}

} // namespace dovetail
