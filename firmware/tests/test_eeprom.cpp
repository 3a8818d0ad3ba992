// Settings in the EEPROM: which are stored, and what damage and power cuts cause.
#include <cstddef>
#include <cstring>
#include <initializer_list>
#include <vector>

#include "check.h"
#include "fake_board.h"
#include "fake_eeprom.h"
#include "kits.h"
#include "motor.h"
#include "settings.h"

namespace {

using fake::fresh_board;
using fake::power_on;
using kits::named;
using kits::same;
using protocol::Board;

bool is_default() { return std::strcmp(settings::now().label, "Hapkit") == 0; }

// Save, and wait until the save is complete; return the number of bytes written.
int save() {
  const int before = fake::eeprom_writes;
  settings::save();
  for (int turn = 0; settings::saving() && turn < 1000; ++turn) settings::poll();
  CHECK(!settings::saving());
  return fake::eeprom_writes - before;
}

}  // namespace

TEST(saved_settings_are_loaded_at_the_start) {
  fresh_board();
  const Board kit = named("mine", 2.0f);
  settings::accept(kit);
  settings::save();
  CHECK(settings::saving() && settings::origin() == protocol::kOriginUnsaved);
  CHECK(save() >= 70);
  CHECK(settings::origin() == protocol::kOriginStored);
  power_on();
  CHECK(settings::origin() == protocol::kOriginStored && same(settings::now(), kit));
  CHECK(same(fake::configured, kit) && motor::duty_of(9.0f).pwm == motor::duty_of(2.0f).pwm);
  CHECK(fake::eeprom[0] == 0xff);
}

TEST(unchanged_bytes_are_not_written) {
  fresh_board();
  CHECK(save() > 0);  // the defaults are written once
  CHECK(save() == 0);
  settings::accept(named("other", 2.0f));
  CHECK(save() > 0);
  CHECK(save() == 0);
  power_on();
  CHECK(save() == 0);
  settings::accept(named("third", 1.0f));
  settings::accept(named("other", 2.0f));
  CHECK(settings::origin() == protocol::kOriginUnsaved);
  CHECK(save() == 0 && settings::origin() == protocol::kOriginStored);
}

TEST(the_newest_of_600_saves_is_loaded) {
  fresh_board();
  for (int i = 0; i < 600; ++i) {  // the sequence number of saves wraps at 256
    settings::accept(named("mine", static_cast<float>(i) * 0.005f));
    save();
    power_on();
    CHECK(settings::now().max_force == static_cast<float>(i) * 0.005f);
  }
}

TEST(every_wrong_bit_is_detected) {
  fresh_board();
  for (int saves : {1, 2}) {
    settings::accept(named("mine", 0.5f * static_cast<float>(saves)));
    save();
    const auto whole = fake::eeprom;
    for (std::size_t at = 0; at < whole.size(); ++at) {
      for (int bit = 0; bit < 8; ++bit) {
        fake::eeprom = whole;
        fake::eeprom[at] ^= 1 << bit;
        power_on();
        const bool stored = settings::origin() == protocol::kOriginStored;
        CHECK(stored ? settings::now().max_force == 0.5f * static_cast<float>(saves) : is_default());
        CHECK(stored || settings::origin() == protocol::kOriginDamaged);
        CHECK(motor::duty_of(99.0f).pwm <= motor::duty_of(3.0f).pwm);
      }
    }
    int damaged = 0;
    for (std::size_t at = 0; at < whole.size(); ++at) {
      fake::eeprom = whole;
      fake::eeprom[at] ^= 0x10;
      power_on();
      damaged += settings::origin() == protocol::kOriginDamaged;
    }
    CHECK(damaged == 2 + Board::kSize + 2);  // mark, number, settings, CRC
    fake::eeprom = whole;
    power_on();
  }
}

TEST(a_valid_block_with_an_implausible_number_counts_as_damaged) {
  fresh_board();
  settings::accept(named("mine", 1.0f));
  save();
  fake::eeprom[16 + 2 + offsetof(Board, sense)] = 3;
  std::vector<uint8_t> block(fake::eeprom.begin() + 16, fake::eeprom.begin() + 16 + 2 + Board::kSize);
  const uint16_t crc = fake::crc_of(block);
  fake::eeprom[16 + block.size()] = crc >> 8;
  fake::eeprom[17 + block.size()] = crc & 0xff;
  power_on();
  CHECK(is_default() && settings::origin() == protocol::kOriginDamaged);
}

// Cut the power after some written bytes, with the last byte half written. Return false if fewer bytes were
// written.
static bool cut_after(int bytes, uint8_t wreck) {
  const int before = fake::eeprom_writes;
  settings::save();
  while (settings::saving()) {
    settings::poll();
    if (fake::eeprom_writes - before == bytes) {
      fake::eeprom[fake::eeprom_last] = wreck;
      return true;
    }
  }
  return false;
}

TEST(a_power_cut_during_a_save_leaves_the_old_or_the_new_settings) {
  for (int saves_before : {0, 1, 2, 3}) {
    for (uint8_t wreck : {0x00, 0xff, 0x55}) {
      bool cut = true;
      for (int bytes = 1; cut; ++bytes) {
        fresh_board();
        for (int i = 1; i <= saves_before; ++i) {
          settings::accept(named("old", 0.1f * static_cast<float>(i)));
          save();
        }
        const Board old = settings::now();
        const Board wanted = named("new and long", 2.5f);
        settings::accept(wanted);
        cut = cut_after(bytes, wreck);
        power_on();
        CHECK(same(settings::now(), old) || same(settings::now(), wanted));
        settings::accept(wanted);
        save();
        power_on();
        CHECK(same(settings::now(), wanted) && settings::origin() == protocol::kOriginStored);
      }
    }
  }
}

// Return true if a slot has a mark and an invalid block after it.
static bool is_wreck(int place) {
  const auto begin = fake::eeprom.begin() + place;
  const std::vector<uint8_t> block(begin, begin + 2 + Board::kSize + 2);
  return block[0] != 0xff && fake::crc_of(block) != 0;
}

TEST(with_two_complete_blocks_a_power_cut_damages_neither) {
  fresh_board();
  float force = 0.25f;
  for (int turn = 0; turn < 6; ++turn) {
    force += 0.25f;
    settings::accept(named("mine", force));
    settings::save();
    const uint16_t mark = turn % 2 ? 272 : 16;
    fake::eeprom_last = 0;
    // run until the new mark is written, before the old one is erased
    for (int poll = 0; poll < 200 && (fake::eeprom_last != mark || fake::eeprom[mark] != 1); ++poll) {
      settings::poll();
      CHECK(!is_wreck(16) && !is_wreck(272));
    }
    power_on();
    CHECK(settings::origin() == protocol::kOriginStored && settings::now().max_force == force);
  }
  CHECK(fake::eeprom[16] == 1 && fake::eeprom[272] == 1);
}

TEST(a_change_during_a_save_cancels_it) {
  fresh_board();
  settings::accept(named("old", 1.0f));
  save();
  settings::accept(named("first", 2.0f));
  settings::save();
  for (int i = 0; i < 30; ++i) settings::poll();
  settings::accept(named("second", 2.5f));
  CHECK(!settings::saving() && settings::origin() == protocol::kOriginUnsaved);
  const auto halfway = fake::eeprom;
  power_on();
  CHECK(same(settings::now(), named("old", 1.0f)));
  fake::eeprom = halfway;
}

TEST(a_save_waits_for_a_busy_eeprom) {
  fresh_board();
  settings::accept(named("mine", 1.0f));
  settings::save();
  fake::eeprom_busy = true;
  for (int i = 0; i < 10; ++i) settings::poll();
  CHECK(fake::eeprom_writes == 0 && settings::saving());
  fake::eeprom_busy = false;
  settings::poll();
  CHECK(fake::eeprom_writes == 1);
}
