// SPDX-License-Identifier: Apache-2.0
#include "common/files/session.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "common/files/atomic_file.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

// FIPS 180-2, appendix B.1: the digest of "abc".
constexpr const char* kAbcSha256 = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";

Session MakeSession(const std::filesystem::path& directory) {
  Session session;
  session.directory = directory;
  session.dermap_version = "0.1.0";
  session.started_utc = "2025-01-02T03:04:05Z";
  session.complete = true;
  session.rig.name = "bench";
  session.rig.slots = {{1, 450.5, 8.5, false}, {9, 0.0, 0.0, true}};
  session.rig.window_mm = 6.25;
  session.rig.light_angle_deg = 12.5;
  session.rig.gray_card_region = {0.1, 0.2, 0.3, 0.4};
  session.rig.simulated_scene = "scenes/x.toml";
  session.plan.subject = "S01";
  session.plan.notes = "left \"arm\"\nof Søren";
  session.plan.exposures = {{1, 12.5, 200}};
  session.frames = {
      {1, FrameRole::kBlack, 9, 0.0, 0.0, 12.5, 200, "frames/0001_black_0nm.dng", kAbcSha256, ""},
      {2, FrameRole::kSkin, 1, 450.5, 8.5, 12.5, 200, "frames/0002_skin_450.5nm.dng", kAbcSha256,
       "2025-01-02T03:04:06Z"}};
  return session;
}

class SessionTest : public testing::Test {
 protected:
  // Writes a good manifest, lets `spoil` change it, and returns what reading it says.
  template <class Spoil>
  std::string SentenceAfter(const Spoil& spoil) {
    WriteSession(MakeSession(folder_.path()));
    json manifest = json::parse(Slurp(folder_ / "session.json"));
    spoil(manifest);
    folder_.Write("session.json", manifest.dump());
    return SentenceOf<InputError>([&] { ReadSession(folder_.path()); });
  }
  TemporaryFolder folder_;
};

// What was written comes back, value for value.
TEST_F(SessionTest, ComesBackAsWritten) {
  const Session written = MakeSession(folder_.path());
  WriteSession(written);
  const Session read = ReadSession(folder_.path());
  EXPECT_EQ(read.dermap_version, written.dermap_version);
  EXPECT_EQ(read.started_utc, written.started_utc);
  EXPECT_TRUE(read.complete);
  EXPECT_EQ(read.rig.name, "bench");
  ASSERT_EQ(read.rig.slots.size(), 2u);
  EXPECT_EQ(read.rig.slots[0].wavelength_nm, 450.5);
  EXPECT_TRUE(read.rig.slots[1].opaque);
  EXPECT_EQ(read.rig.window_mm, 6.25);
  EXPECT_EQ(read.rig.light_angle_deg, 12.5);
  EXPECT_EQ(read.rig.gray_card_region, written.rig.gray_card_region);
  EXPECT_EQ(read.rig.simulated_scene, "scenes/x.toml");
  EXPECT_EQ(read.rig.spectralon_csv, written.rig.spectralon_csv);
  EXPECT_EQ(read.plan.notes, written.plan.notes);
  EXPECT_EQ(read.plan.exposures.at(0).exposure_ms, 12.5);
  ASSERT_EQ(read.frames.size(), 2u);
  EXPECT_EQ(read.frames[0].role, FrameRole::kBlack);
  EXPECT_EQ(read.frames[1].file, "frames/0002_skin_450.5nm.dng");
  EXPECT_EQ(read.frames[1].wavelength_nm, 450.5);
  EXPECT_EQ(read.frames[1].sha256, kAbcSha256);
  EXPECT_EQ(read.frames[1].time_utc, "2025-01-02T03:04:06Z");
}

// DESIGN: frames/NNNN_role_wavelength.dng.
TEST_F(SessionTest, NamesFramesByNumberRoleAndWavelength) {
  EXPECT_EQ(FrameFileName({7, FrameRole::kSkin, 1, 450.0, 10, 10, 400, "", "", ""}, "dng"),
            "frames/0007_skin_450nm.dng");
  EXPECT_EQ(FrameFileName({12345, FrameRole::kSpectralon, 1, 632.8, 10, 10, 400, "", "", ""}, ".cr2"),
            "frames/12345_spectralon_632.8nm.cr2");
}

// A manifest must not lead out of its folder, name a frame twice, or hold what no frame can have.
TEST_F(SessionTest, RejectsManifestsThatCannotBe) {
  const auto frame = [](json& manifest) -> json& { return manifest["frames"][1]; };
  EXPECT_THAT(SentenceAfter([&](json& m) { frame(m)["file"] = "../../etc/passwd"; }),
              AllOf(HasSubstr("session.json"), HasSubstr("frame 2"), HasSubstr("inside the session folder")));
  EXPECT_THAT(SentenceAfter([&](json& m) { frame(m)["file"] = "/etc/passwd"; }),
              HasSubstr("inside the session folder"));
  EXPECT_THAT(SentenceAfter([&](json& m) { frame(m)["file"] = "frames/./0001_black_0nm.dng"; }),
              HasSubstr("is given twice"));
  EXPECT_THAT(SentenceAfter([&](json& m) { frame(m)["role"] = "grey"; }),
              HasSubstr("black, spectralon, skin"));
  EXPECT_THAT(SentenceAfter([&](json& m) { frame(m)["number"] = 1; }),
              HasSubstr("the number 1 is given twice"));
  EXPECT_THAT(SentenceAfter([&](json& m) { frame(m)["iso"] = "high"; }),
              HasSubstr("'frames[2].iso' is the text"));
  EXPECT_THAT(SentenceAfter([&](json& m) { frame(m)["sha256"] = "abc"; }),
              HasSubstr("64 hexadecimal digits"));
  EXPECT_THAT(SentenceAfter([&](json& m) { frame(m).erase("exposure_ms"); }),
              HasSubstr("exposure_ms' is missing"));
  EXPECT_THAT(SentenceAfter([&](json& m) { frame(m)["wavelength_nm"] = 1e300; }),
              HasSubstr("from 350 to 1000"));
  EXPECT_THAT(SentenceAfter([&](json& m) { m["frames"] = 3; }), HasSubstr("[[frames]]"));
  EXPECT_THAT(SentenceAfter([&](json& m) { m.erase("rig"); }), HasSubstr("'rig' is missing"));
  EXPECT_THAT(SentenceAfter([&](json& m) { m["format_version"] = 2; }),
              HasSubstr("expected 'dermap session'"));
  EXPECT_THAT(SentenceAfter([&](json& m) { m["complete"] = 1; }), HasSubstr("expected true or false"));
  EXPECT_THAT(SentenceAfter([&](json& m) { m = json::array(); }), HasSubstr("expected an object"));
}

// Found by manifest_fuzz: a number that no double holds ended the program.
TEST_F(SessionTest, RejectsNumbersThatOverflow) {
  for (const char* text : {"{\"exposure_changes\": 8e6178}", "{\"exposure_changes\": [-1e999]}"}) {
    folder_.Write("session.json", text);
    EXPECT_THAT(SentenceOf<InputError>([&] { ReadSession(folder_.path()); }),
                AllOf(HasSubstr("session.json"), HasSubstr("beyond 1.8e308")))
        << text;
  }
}

// Half a manifest, no manifest, no folder.
TEST_F(SessionTest, NamesWhatIsMissing) {
  EXPECT_THAT(SentenceOf<InputError>([&] { ReadSession(folder_ / "none"); }),
              HasSubstr("it is not a folder"));
  EXPECT_THAT(SentenceOf<InputError>([&] { ReadSession(folder_.path()); }),
              AllOf(HasSubstr("session.json"), HasSubstr("No such file")));
  WriteSession(MakeSession(folder_.path()));
  const std::string whole = Slurp(folder_ / "session.json");
  for (const std::size_t length : {std::size_t{0}, std::size_t{1}, whole.size() / 2, whole.size() - 3}) {
    folder_.Write("session.json", whole.substr(0, length));
    EXPECT_THAT(SentenceOf<InputError>([&] { ReadSession(folder_.path()); }), HasSubstr("not valid JSON"))
        << length;
  }
  std::string deep = "{\"a\":";
  for (int i = 0; i < 2000; ++i) deep += "[";
  for (int i = 0; i < 2000; ++i) deep += "]";
  folder_.Write("session.json", deep + "}");
  EXPECT_THAT(SentenceOf<InputError>([&] { ReadSession(folder_.path()); }), HasSubstr("'format' is missing"));
}

// FIPS 180-2's "abc": the frame is right, then changed by one byte, then gone.
TEST_F(SessionTest, VerifiesFramesByTheirDigest) {
  Session session = MakeSession(folder_.path());
  folder_.Write("frames/0001_black_0nm.dng", "abc");
  folder_.Write("frames/0002_skin_450.5nm.dng", "abc");
  EXPECT_NO_THROW(VerifyFrames(session));
  folder_.Write("frames/0002_skin_450.5nm.dng", "abd");
  EXPECT_THAT(SentenceOf<InputError>([&] { VerifyFrames(session); }),
              AllOf(HasSubstr("0002_skin_450.5nm.dng"), HasSubstr("ba7816bf8f01")));
  std::filesystem::remove(folder_ / "frames/0002_skin_450.5nm.dng");
  EXPECT_THAT(SentenceOf<InputError>([&] { VerifyFrames(session); }), HasSubstr("No such file"));
}

// The journal's lines hold frames in the manifest's form, with the same checks.
TEST_F(SessionTest, FramesGoThroughJson) {
  const FrameRecord frame = MakeSession("").frames[1];
  const FrameRecord read = FrameFromJson(FrameToJson(frame), "journal line 1");
  EXPECT_EQ(read.number, frame.number);
  EXPECT_EQ(read.file, frame.file);
  json bad = FrameToJson(frame);
  bad["iso"] = -1;
  EXPECT_THAT(SentenceOf<InputError>([&] { FrameFromJson(bad, "journal line 1"); }),
              HasSubstr("journal line 1"));
}

}  // namespace
}  // namespace dermap
