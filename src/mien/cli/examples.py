"""Two commands a verb, as its help shows them."""

EXAMPLES = {
    "demo": (
        ("mien demo", "markers to a moving face on the bundled actor"),
        ("mien demo rgbd", "the same from colour and depth"),
    ),
    "solve": (
        ("mien solve take.c3d -o perf.glb", "markers to an animated face"),
        ("mien solve take.c3d --rig me.glb -o perf.usdc", "on a rig of your own, as USD"),
    ),
    "select": (
        ("mien select take.c3d -o selection.json", "which frames to scan"),
        ("mien select take.c3d -o selection.json --markers 'Actor:*'", "of one actor's markers"),
    ),
    "register": (
        ("mien register calm.ply -o face.glb", "one scan to a rig with 52 shapes"),
        ("mien register scans/ --markers take.c3d --selection selection.json -o rig.glb", "all scans of a take"),
    ),
    "scan": (
        ("mien scan smile/ -o smile.ply", "a held expression to one textured scan"),
        ("mien scan smile.r3d -o smile.exr", "as a map"),
    ),
    "rig": (
        ("mien rig captures/ -o me.glb", "a folder of captures to a textured rig"),
        ("mien rig captures/ --arkit -o me.glb", "with all 52 ARKit shapes"),
    ),
    "personalize": (
        ("mien personalize take/ -o rig.glb", "a calm face before an RGB-D camera to a rig"),
        ("mien personalize clip.mp4 -o rig.glb", "from colour alone"),
    ),
    "track": (
        ("mien track clip.mp4 -o perf.glb", "a video to an animated face"),
        ("mien track livelink --rig rig.glb -o perf.glb", "record the Live Link Face app"),
    ),
    "retarget": (
        ("mien retarget perf.glb --to avatar.vrm -o out.glb", "onto an avatar"),
        ("mien retarget perf.glb --to rig.glb --map names.csv -o out.glb", "with names by hand"),
    ),
    "detail": (
        ("mien detail fit training/ -o maps/", "learn wrinkles and pores"),
        ("mien detail synth perf.glb --maps maps/ -o detail.mp4", "play them"),
    ),
    "decode": (
        ("mien decode take/ -o scan.exr", "pictures of active light to a detailed scan"),
        ("mien decode --show paper -o patterns/", "the patterns to project"),
    ),
    "view": (
        ("mien view perf.glb", "see it move in the browser"),
        ("mien view perf.glb take.c3d --export page/", "a page to mail, markers over the face"),
    ),
    "render": (
        ("mien render perf.glb -o perf.mp4", "a film"),
        ("mien render perf.glb --sheet 12 -o sheet.png", "a contact sheet"),
    ),
    "convert": (
        ("mien convert perf.glb -o perf.usdz", "to USD"),
        ("mien convert app.csv --rig avatar.vrm -o perf.glb", "a Live Link Face file onto an avatar"),
    ),
    "stream": (
        ("mien stream perf.glb --vmc 127.0.0.1:39539 --loop", "to an avatar program"),
        ("mien stream live --livelink 192.168.1.20:11111", "a webcam to Unreal"),
    ),
    "doctor": (
        ("mien doctor", "what is installed, what is missing, how fast this machine is"),
        ("mien doctor --json", "the same for a program"),
    ),
    "fetch": (
        ("mien fetch", "bring the landmark model"),
        ("mien fetch landmarks", "the same, named"),
    ),
}
