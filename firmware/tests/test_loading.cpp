// Transfer of a law: pieces in order, lost, damaged and unknown, and laws that the board refuses.
#include "rendering.h"
#include "settings.h"

namespace {

using machine::Refusal;

// Return a law with this many bytes that has no effect.
Law long_law(std::size_t bytes) {
  Law law{{1.0f}, std::vector<uint8_t>(bytes - 4, machine::kAbsolute)};
  law.code.front() = machine::kMain;
  law.code.back() = machine::kReturn;
  return law;
}

protocol::Sample status(Rendering& board) { return board.sample(kStill); }

Refusal refusal(Rendering& board) { return static_cast<Refusal>(status(board).refusal); }

}  // namespace

TEST(samples_report_the_received_bytes_of_a_law) {
  Rendering board;
  const Law law = long_law(100);
  auto sample = status(board);
  CHECK(sample.generation == 0 && sample.received == 0 && sample.refusal == 0);
  board.receive(head_of(law, 7, at(1000)));
  CHECK(status(board).generation == 7);
  for (uint16_t from = 0; from < 96; from += protocol::kPiece) {
    sample = status(board);
    CHECK(sample.generation == 7 && sample.received == from);
    board.receive(piece_of(law, 7, from));
  }
  CHECK(status(board).received == 96);
  board.receive(piece_of(law, 7, 96));
  CHECK(board.shown().generation == 7);
}

TEST(only_pieces_of_the_announced_law_are_accepted_in_order) {
  Rendering board;
  const Law law = long_law(100);
  board.receive(piece_of(law, 7, 0));  // this law was not announced
  board.receive(head_of(law, 7, at(1000)));
  CHECK(status(board).received == 0);
  board.receive(piece_of(law, 7, 32));
  board.receive(piece_of(law, 6, 0));
  CHECK(status(board).received == 0);
  board.receive(piece_of(law, 7, 0));
  board.receive(piece_of(law, 7, 0));
  board.receive(piece_of(law, 7, 64));
  CHECK(status(board).received == 32);
  board.receive(head_of(law, 7, at(1000)));  // the law is announced again, and nothing is lost
  CHECK(status(board).received == 32);
  for (uint16_t from : {32, 64, 96}) board.receive(piece_of(law, 7, from));
  CHECK(board.shown().generation == 7);
}

TEST(a_damaged_law_is_requested_again) {
  Rendering board;
  const Law law = long_law(60);
  board.receive(head_of(law, 7, at(1000)));
  auto wrong = piece_of(law, 7, 32);
  wrong.data[3] ^= 4;
  board.receive(piece_of(law, 7, 0));
  board.receive(wrong);
  const auto sample = status(board);
  CHECK(sample.received == 0 && sample.refusal == 0 && sample.generation == 7);
  board.send(law, 7);
  CHECK(board.shown().generation == 7);
}

TEST(the_bytes_are_stored_in_the_layout_of_the_machine) {
  Rendering board;
  Law law = counter(5);
  law.slots = kFirst + 4 + 3;
  std::memset(machine::arena, 0xa5, sizeof(machine::arena));
  board.change(law, 7);
  const float* slots = machine::slots();
  for (std::size_t i = 0; i < law.given.size(); ++i) CHECK(slots[kFirst + i] == law.given[i]);
  for (uint8_t i = kFirst + 4; i < law.slots; ++i) CHECK(slots[i] == 0.0f);
  const machine::Shape shape{law.states, 4, law.slots, static_cast<uint16_t>(law.code.size())};
  CHECK(std::memcmp(machine::code(shape), law.code.data(), law.code.size()) == 0);
  // The zeros that pad the piece after the last byte are not written.
  CHECK(machine::code(shape)[law.code.size()] == 0xa5);
}

TEST(a_law_that_is_too_large_is_refused_at_once) {
  const Law law = spring(100);
  const auto head = head_of(law, 7, at(1000));
  for (int which = 0; which < 5; ++which) {
    Rendering board;
    auto bad = head;
    if (which == 0) bad.code = machine::kArena;
    if (which == 1) bad.code = 65535;
    if (which == 2) bad.slots = 255;
    if (which == 3) bad.given = 2;  // there are more given values than slots
    if (which == 4) bad.states = 2;
    board.receive(bad);
    const auto sample = status(board);
    CHECK(sample.generation == 7 && sample.refusal == static_cast<uint8_t>(Refusal::kTooLarge));
    board.send(law, 7);
    CHECK(status(board).received == 0);
  }
}

TEST(the_largest_law_leaves_memory_for_ramps) {
  Rendering board;
  const std::size_t most = machine::kArena - 4 * (kFirst + 1) - machine::kRamps * machine::kRamp;
  board.receive(head_of(long_law(most + 4 + 1), 7, at(500)));
  CHECK(refusal(board) == Refusal::kTooLarge);
  const Law law = long_law(most + 4);
  board.receive(head_of(law, 8, at(500)));
  CHECK(refusal(board) == Refusal::kNone);
  board.send(law, 8);
  board.alive(4);
  CHECK(board.shown().generation == 8);
}

TEST(unsupported_rates_and_estimators_are_refused_at_once) {
  const estimator::Loop loops[] = {{499, 0, 0, 0},     {4001, 0, 0, 0},     {0, 0, 0, 0},
                                   {2000, 3, 0, 0},    {2000, 1, NAN, 0},   {2000, 1, 1.01f, 0},
                                   {2000, 2, 0.5f, 2000}, {2000, 2, -0.1f, 0}};
  for (const auto& loop : loops) {
    Rendering board;
    board.receive(head_of(spring(100), 7, loop));
    CHECK(refusal(board) == Refusal::kRate);
  }
}

TEST(a_law_that_the_verifier_rejects_is_not_run) {
  Law no_end = spring(100), wide = spring(100), infinite = spring(INFINITY), empty{{}, {}};
  no_end.code.pop_back();
  wide.code[2] = 200;
  const std::pair<Law, Refusal> wrong[] = {{no_end, Refusal::kEnd}, {wide, Refusal::kSlot},
                                           {infinite, Refusal::kConstant}, {empty, Refusal::kEnd}};
  for (const auto& [law, why] : wrong) {
    Rendering board(spring(200));
    board.alive(2 * kFadeMs);
    CHECK(fake::pwm != 0);
    board.change(law, 7);
    board.period(kStill);
    CHECK(fake::pwm == 0 && refusal(board) == why);
    board.change(spring(200), 8);
    board.alive(2 * kFadeMs);
    CHECK(fake::pwm != 0 && board.shown().generation == 8);
  }
}

TEST(a_law_slower_than_its_rate_is_refused_and_runs_at_a_lower_one) {
  using namespace machine;
  Law law{{1.0f}, {kMain, kLoop, 0, 100, 0, kMultiply, kFirst, kNext, 0, 6, 0, kReturn}};
  Rendering board;
  board.change(law, 7, at(4000));
  CHECK(refusal(board) == Refusal::kTooSlow);
  board.change(law, 8, at(500));
  board.period(kStill);
  board.period(kStill);
  fake::sent.clear();
  CHECK(board.shown().generation == 8);
}

TEST(leave_or_a_kit_change_cancels_the_transfer_of_a_law) {
  for (bool kit : {false, true}) {
    Rendering board;
    const Law law = long_law(100);
    board.receive(head_of(law, 7, at(1000)));
    board.receive(piece_of(law, 7, 0));
    if (kit) {
      board.receive(settings::now());
      board.period(kStill);
    } else {
      board.receive(protocol::Leave{});
    }
    for (uint16_t from : {32, 64, 96}) board.receive(piece_of(law, 7, from));
    const auto sample = status(board);
    CHECK(sample.generation == 7 && sample.received == 32);
    board.change(law, 8);
    CHECK(board.shown().generation == 8);
  }
}

TEST(the_computer_renders_until_the_law_is_complete) {
  Rendering board;
  const Law law = spring(200);
  board.receive(head_of(law, 7, at(1000)));
  for (int i = 0; i < 40; ++i) {
    board.receive(protocol::Force{board.seq(), 0, 1.0f});
    board.period(kStill);
    CHECK(fake::pwm > 0);
  }
  board.send(law, 7);
  board.period(kStill);
  CHECK(fake::pwm <= 0);
  board.alive(2 * kFadeMs);
  CHECK(fake::pwm < 0);
}
