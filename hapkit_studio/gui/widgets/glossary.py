"""Terms used in the window, each explained in two short sentences."""

WORDS = {
    "Added delay": (
        "Extra time between sensor and motor, to show the effect of a slow link. The force then "
        "depends on where the handle was, so a stiff wall begins to buzz."
    ),
    "Bode": (
        "A chart that shows, for each frequency of motion, how strong the force is and how late. A "
        "rendered wall is stiff for slow motions only: above some frequency it is soft or gives "
        "energy."
    ),
    "Buzzes": (
        "The handle keeps oscillating at the same size. In each cycle, the loop adds as much "
        "energy as friction takes away."
    ),
    "Clamped": (
        "The law asks for more force than the motor may give, so the force is cut to the limit. "
        "Beyond that point a wall feels softer than its setting."
    ),
    "Coulomb friction": (
        "Dry friction: the same force at any speed, always against the motion. It can stop a buzz."
    ),
    "Damping": (
        "A force against the motion, in proportion to speed. It takes energy away, unless the speed is "
        "measured too late."
    ),
    "E-stop": ("Sets the force to zero at once. The force stays zero until you release the E-stop."),
    "Estimator": (
        "The method that computes the speed from measured positions. The smoother the estimate, the longer "
        "its delay."
    ),
    "Fault": ("A safety check has failed, and the force is zero. It stays zero until you clear the fault."),
    "Grows": (
        "The handle swings farther and farther, up to the motor's limit. The loop adds more "
        "energy than friction and damping take away."
    ),
    "Impedance": (
        "How much force is needed for a motion: stiffness, damping and mass together. A free handle has a "
        "low impedance, a wall has a high one."
    ),
    "Kalman": (
        "An estimator that predicts the speed with a model and corrects it with each sample. It "
        "is smooth, and less late than an equally smooth filter."
    ),
    "Knock": (
        'A short, hard push. "A knock of more than 0.9 mm makes it buzz" means that the handle '
        "comes to rest if a push moves it by less."
    ),
    "Limit": (
        "The greatest stiffness at which small oscillations of the handle die out. It is computed "
        "for this loop without dry friction; the view Stability can measure it."
    ),
    "Margin": (
        "The stiffness limit divided by the stiffness that is set. Below 1, small oscillations grow instead "
        "of dying out."
    ),
    "Passivity": (
        "A passive loop never gives out more energy than was put into it, whoever holds the "
        "handle. This is stricter than stable: many loops are stable but not passive."
    ),
    "Passivity controller": (
        "Adds up the energy that goes in and out at the handle. While the scene has given out "
        "more than it received, the controller adds just enough damping."
    ),
    "Quantization": (
        "The sensor measures the position in small steps. A speed computed from these steps jumps, so with "
        "damping the handle rattles."
    ),
    "Rendering": (
        "Computing the force of a virtual environment and making the motor push with it. The "
        "asked force is what the law wants, the applied force is what the motor gives."
    ),
    "Servo rate": (
        "How many times per second the force is computed. Between two computations, the force "
        "stays the same, which adds a little energy in each cycle."
    ),
    "Stable": (
        "The handle comes to rest after any push, in your hand and after you let go. Friction "
        "helps, so a scene may be stable above the limit, which is computed without friction."
    ),
    "Stiffness": ("Force per metre of displacement. Twice the stiffness pushes back twice as hard."),
    "Texture": (
        "Small ridges of force that feel like a rough surface. The faster you move, the faster "
        "they shake the handle."
    ),
    "Tick": (
        "One pass of the loop: read the sensor, compute the force, command the motor. After a "
        "missed tick, the old force continues."
    ),
    "Trigger": (
        "Stops the time plots when the handle touches something or crosses a level, and shows what "
        "happened before. Rendering and recording continue."
    ),
    "Virtual environment": (
        "A rule that gives a force for each position and speed of the handle. The wall or spring "
        "that you feel is only this rule."
    ),
    "Z-width": (
        "The range of impedances that a device can render stably. It reaches from the freely moving handle "
        "to the stiffest stable wall."
    ),
}
