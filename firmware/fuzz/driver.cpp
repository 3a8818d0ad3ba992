// Fuzzing without clang: random mutations of the corpus, reproducible by seed.
// Usage: driver COUNT SEED CORPUS...; prints the number of inputs.

#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <set>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size);

namespace {

using Bytes = std::vector<uint8_t>;
constexpr std::size_t kLongest = 200;

std::mt19937_64 chance;

std::size_t below(std::size_t limit) { return chance() % limit; }

std::vector<Bytes> read_corpus(int count, char** folders) {
  std::set<std::filesystem::path> paths;  // a set has the same order on every machine
  for (int k = 0; k < count; ++k)
    for (const auto& entry : std::filesystem::directory_iterator(folders[k])) paths.insert(entry.path());
  std::vector<Bytes> found;
  for (const auto& path : paths) {
    std::ifstream file(path, std::ios::binary);
    found.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return found;
}

void change(Bytes* input, const Bytes& other) {
  const std::size_t at = input->empty() ? 0 : below(input->size());
  switch (input->empty() ? 3 : below(6)) {
    case 0: (*input)[at] ^= static_cast<uint8_t>(1u << below(8)); break;
    case 1: (*input)[at] = static_cast<uint8_t>(chance()); break;
    case 2: input->erase(input->begin() + at); break;
    case 3: input->insert(input->begin() + at, static_cast<uint8_t>(chance())); break;
    case 4: input->insert(input->begin() + at, other.begin(), other.end()); break;
    default: (*input)[at] = static_cast<uint8_t>((*input)[at] + (below(2) ? 1 : 255)); break;
  }
  if (input->size() > kLongest) input->resize(kLongest);
}

}  // namespace

int main(int count, char** words) {
  if (count < 4) return 2;
  const uint64_t wanted = std::strtoull(words[1], nullptr, 10);
  chance.seed(std::strtoull(words[2], nullptr, 10));
  const std::vector<Bytes> corpus = read_corpus(count - 3, words + 3);
  if (corpus.empty()) return 2;
  for (const Bytes& input : corpus) LLVMFuzzerTestOneInput(input.data(), input.size());
  for (uint64_t done = corpus.size(); done < wanted; ++done) {
    Bytes input = corpus[below(corpus.size())];
    for (std::size_t left = 1 + below(6); left; --left) change(&input, corpus[below(corpus.size())]);
    LLVMFuzzerTestOneInput(input.data(), input.size());
  }
  std::printf("%" PRIu64 " inputs\n", wanted);
}
