"""Fails on flags in a vector<char> in core/alignment (of photos they are a PhotoSet, of others a field or a vector<bool>), on
more than 20 casts to std::size_t there: an index of the right type needs none; and on a type more that stands for a photo, a
point, a pair or a flight: each is a copy of what others hold, and twelve would do. Where two are merged MOST_TYPES is lowered."""
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1])
LIMIT = 20
FLAGS = re.compile(r"\bvector<\s*char\s*>")
CAST = re.compile(r"\bstatic_cast<(?:std::)?size_t>")
TYPE = re.compile(r"^(?:struct|class) (\w+)[^;\n]*$", re.M)  # of a header, not within another type

MOST_TYPES = 24
STANDS_FOR = {
    "photo": """AlignPhotoReport AlignedPhoto BundlePhoto FoundPose PhotoFeatures PhotoFindings
        PhotoGround PhotoRecord View""",
    "point": "GroundKeypoint Keypoint Observation PointObservation Track TrackElement",
    "pair": "AlignPairReport PhotoPair PlacePair",
    "flight": "AlignedFlight Attempt BundleProblem ExtractedFlight MatchedFlight Registration",
}
# Options and questions, verdicts and reports, surveyed points, lenses, pictures, and what is computed with.
OTHERS = """AlignLensReport AlignOptions AlignReport Appearance AttemptEvidence AveragedRotations BestPartners Block BlockPlace
    BlurredImage BundleControl BundleLens BundleOptions BundlePlane BundleSummary ByImagesReport CameraStart CandidateOptions
    ConnectedComponents ControlMarkReport ControlPoint ControlPrediction ControlReport ControlSighting DetailCell DisjointSets
    FindPoseOptions FittedSimilarity GeoreferenceRecords GroundGraph GroundSimilarity GyroReport Levelling
    MarkedPhotos MatchWindow MatchingPass Octave PairQuestion PhotoSet PositionLag PriorResidual RayIntersection ReadoutDoubt
    RecordResidual Relief RobustFit Sampler ScalePoint Similarity3 Support Thumbnail TimedPositionResidual TrackOptions
    TrackSpread UpDirection VerificationOptions WidePair"""

problems, casts, types = [], [], {}
for path in sorted((ROOT / "core" / "alignment").rglob("*.*")):
    if path.suffix in (".h", ".cc"):
        text = path.read_text()
        for number, line in enumerate(text.splitlines(), 1):
            place = f"{path.relative_to(ROOT)}:{number}"
            problems += [f"{place}: flags in a vector<char>" for _ in FLAGS.findall(line)]
            casts += [place for _ in CAST.findall(line)]
        if path.suffix == ".h":
            types |= {name: path.relative_to(ROOT) for name in TYPE.findall(text)}
if len(casts) > LIMIT:
    problems.append(f"core/alignment: {len(casts)} casts to std::size_t, the limit is {LIMIT}: {', '.join(casts)}")
counted = [name for names in STANDS_FOR.values() for name in names.split()]
listed = counted + OTHERS.split()
problems += [f"{types[name]}: {name} is on no list of this test" for name in sorted(types.keys() - set(listed))]
problems += [f"{name} is on a list of this test, but no type of core/alignment" for name in sorted(set(listed) - types.keys())]
problems += [f"{name} is on two lists of this test" for name in sorted(set(listed)) if listed.count(name) > 1]
if len(counted) != MOST_TYPES:
    problems.append(f"{len(counted)} types stand for a photo, a point, a pair or a flight, {MOST_TYPES} are allowed: lower it where "
                    "two were merged, merge where one was added")
print("\n".join(problems) or f"no flags in a vector<char>, {len(casts)} casts to std::size_t, {len(counted)} types of a photo, a "
                             "point, a pair or a flight")
sys.exit(1 if problems else 0)
