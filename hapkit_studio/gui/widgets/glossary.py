"""The window's words, each explained in two short sentences."""

WORDS = {
    "Added delay": (
        "Time put between sensor and motor on purpose, to show what a slow link does. The force then "
        "answers where the handle was, so a stiff wall begins to buzz."
    ),
    "Bode": (
        "A drawing of how much force a motion meets, and how late, over the motion's frequency. A rendered "
        "wall is stiff for slow motions only: above some frequency it is soft, or gives energy."
    ),
    "Buzzes": (
        "The handle swings to and fro about a surface and neither rests nor grows. The loop gives it as "
        "much energy in each swing as friction takes away."
    ),
    "Calm": (
        "The handle comes to rest from any push, in the hand and let go. Friction counts here, so a scene "
        "may be calm above the linear limit."
    ),
    "Clamped": (
        "The law asks for more force than the motor may give, and the force is cut there. Beyond that point"
        " a wall feels softer than it was set."
    ),
    "Coulomb friction": (
        "Dry friction: the same force at any speed, always against the motion. It can hold still what would"
        " otherwise buzz."
    ),
    "Damping": (
        "A force against the motion, in proportion to speed. It takes energy away, as long as speed is "
        "measured early enough."
    ),
    "E-stop": (
        "Puts the force to zero at the next tick and keeps it there. It stays so until a person releases it."
    ),
    "Estimator": (
        "How speed is made from positions that come in steps. The smoother it is, the later it is."
    ),
    "Fault": (
        "A check has found something that must not go on, and the force is zero. It stays so until a person"
        " clears it."
    ),
    "Grows": (
        "The handle swings farther and farther, up to the motor's limit. The loop gives it more energy than"
        " anything takes away."
    ),
    "Impedance": (
        "How much force a motion meets: stiffness, damping and mass together. A free handle has a low one, "
        "a wall a high one."
    ),
    "Kalman": (
        "An estimator that predicts speed from a model and corrects it with each sample. It is smooth, and "
        "less late than a filter as smooth."
    ),
    "Limit": (
        "The greatest stiffness with which small swings of the handle die out. It is computed for this loop"
        " without dry friction, and measured on the page Stability."
    ),
    "Margin": (
        "How many times the stiffness may grow before the limit is met. Below 1 small swings grow instead "
        "of dying out."
    ),
    "Passivity": (
        "A passive loop never gives out more energy than was put into it, whoever holds the handle. That is"
        " stricter than stable: many loops are stable without being passive."
    ),
    "Passivity controller": (
        "Counts the energy that goes in and out at the handle. While the scene gives out more than it got, "
        "it adds just enough damping."
    ),
    "Quantization": (
        "The sensor counts steps and sees nothing between two of them. A speed made from them jumps, and "
        "with damping the handle rattles."
    ),
    "Rendering": (
        "Computing the force of a virtual environment and having the motor push with it. Asked is what the "
        "law wants; applied is what the motor was given."
    ),
    "Servo rate": (
        "How often the force is computed anew. Between two ticks it is held, which gives a little energy to"
        " the handle at each swing."
    ),
    "Settles": (
        'The handle comes to rest by itself. "Settles below 0.9 mm, buzzes above" names the push, in or out'
        " of the surface, from which it no longer does."
    ),
    "Stiffness": (
        "Force for each metre that something is pushed in. Twice the stiffness pushes back twice as hard."
    ),
    "Texture": (
        "Small ridges of force that feel like a rough surface. Moved across faster, they shake faster."
    ),
    "Tick": (
        "One pass of the loop: read the sensor, compute the force, tell the motor. A missed tick came too "
        "late, and the old force went on."
    ),
    "Trigger": (
        "Lets the time plots stand when the handle touches something or crosses a level, with time before "
        "it in sight. What is rendered and recorded goes on."
    ),
    "Virtual environment": (
        "A rule that gives a force for each place and speed of the handle. What is felt, a wall or a "
        "spring, is only that rule."
    ),
    "Z-width": (
        "The range of impedances that a device can render and stay stable. It reaches from the handle "
        "moving free to the stiffest wall that is calm."
    ),
}
